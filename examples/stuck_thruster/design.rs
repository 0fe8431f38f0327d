//! The designs that are compared.

use faregate::tickets::lock::Strategy;

use crate::flight::Flight;
use crate::scene::Scene;
use crate::stage::Stage;
use crate::tape::Tape;
use crate::tickets::Variant;
use crate::{rivals, tickets};

/// A design without tickets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rival {
    BareCommands,
    SuspendedMonitor,
    Convention,
}

/// What is left out of the power margin design.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ablation {
    Quiescence,
    Safing,
    Confirmation,
    FreshEstimates,
    Lease,
}

/// A design.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Design {
    Tickets(Variant),
    Rival(Rival),
}

/// Whether a design must save every spacecraft, or must lose some.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Kind {
    Tickets,
    Rival,
    Ablation,
}

impl Design {
    pub(crate) const ALL: [Self; 10] = [
        Self::Tickets(Variant::Exclusive),
        Self::Tickets(Variant::PowerMargin),
        Self::Rival(Rival::BareCommands),
        Self::Rival(Rival::SuspendedMonitor),
        Self::Rival(Rival::Convention),
        Self::Tickets(Variant::Without(Ablation::Quiescence)),
        Self::Tickets(Variant::Without(Ablation::Safing)),
        Self::Tickets(Variant::Without(Ablation::Confirmation)),
        Self::Tickets(Variant::Without(Ablation::FreshEstimates)),
        Self::Tickets(Variant::Without(Ablation::Lease)),
    ];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Tickets(Variant::Exclusive) => "tickets, exclusive",
            Self::Tickets(Variant::PowerMargin) => "tickets, power margin",
            Self::Rival(Rival::BareCommands) => "bare commands",
            Self::Rival(Rival::SuspendedMonitor) => "suspended monitor",
            Self::Rival(Rival::Convention) => "allocations by convention",
            Self::Tickets(Variant::Without(Ablation::Quiescence)) => {
                "without quiescence (bare flag)"
            }
            Self::Tickets(Variant::Without(Ablation::Safing)) => "without safing",
            Self::Tickets(Variant::Without(Ablation::Confirmation)) => "without confirmation",
            Self::Tickets(Variant::Without(Ablation::FreshEstimates)) => "with stale estimates",
            Self::Tickets(Variant::Without(Ablation::Lease)) => "without a lease",
        }
    }

    pub(crate) fn kind(self) -> Kind {
        match self {
            Self::Rival(_) => Kind::Rival,
            Self::Tickets(Variant::Without(_)) => Kind::Ablation,
            Self::Tickets(_) => Kind::Tickets,
        }
    }

    /// Flies one scene with this design.
    pub(crate) fn fly<S: Strategy>(self, scene: &Scene, stage: &Stage, tape: &Tape) -> Flight {
        match self {
            Self::Rival(rival) => {
                rivals::fly(&scene.clone().without_deaths().without_hangs(), rival, stage, tape)
            }
            Self::Tickets(Variant::Exclusive) => {
                tickets::fly::<S>(&scene.clone().without_hangs(), Variant::Exclusive, stage, tape)
            }
            Self::Tickets(variant) => tickets::fly::<S>(scene, variant, stage, tape),
        }
    }
}
