//! Policies: what an agent's valid tickets must keep to, together.

use core::fmt;

use faregate_tickets::amount::{Microjoules, Milligrams, Milliwatts};

/// A set of up to 128 conflict categories. Devices that share one are never
/// used by two valid tickets at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Categories(u128);

impl Categories {
    /// Conflicts with nothing.
    pub const NONE: Self = Self(0);
    /// Every category.
    pub const ALL: Self = Self(u128::MAX);

    /// By the bits of a mask.
    #[must_use]
    pub const fn from_mask(mask: u128) -> Self {
        Self(mask)
    }

    /// The bits as a mask.
    #[must_use]
    pub const fn mask(self) -> u128 {
        self.0
    }

    /// Whether the two share a category.
    #[must_use]
    pub const fn overlaps(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// The categories of both.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// The categories that both have.
    #[must_use]
    pub const fn shared(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Whether there is none.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }
}

impl fmt::Display for Categories {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:#x}", self.0)
    }
}

/// What an agent's valid tickets must keep to, together. Rules compose: each
/// one that is there must agree.
///
/// ```
/// use faregate_agents::Policy;
/// use faregate_tickets::amount::{Microjoules, Milliwatts};
///
/// let on_battery = Policy::power_margin(Milliwatts::from_watts(40))
///     .with_categories()
///     .with_energy(Microjoules::from_joules(500));
/// # let _ = on_battery;
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Policy {
    pub(crate) exclusive: bool,
    pub(crate) supply: Option<Milliwatts>,
    pub(crate) categories: bool,
    pub(crate) energy: Option<Microjoules>,
    pub(crate) propellant: Option<Milligrams>,
}

impl Policy {
    /// One valid ticket at a time in the agent's whole command group, the most
    /// important (Gat 2000, section 2, "Ticket agents").
    #[must_use]
    pub fn exclusive() -> Self {
        Self { exclusive: true, ..Self::default() }
    }

    /// As many tickets as the supply allows, in order of importance (Gat 2000,
    /// section 2, "A more realistic policy").
    #[must_use]
    pub fn power_margin(supply: Milliwatts) -> Self {
        Self { supply: Some(supply), ..Self::default() }
    }

    /// As many tickets as share no conflict category, in order of importance.
    #[must_use]
    pub fn categories() -> Self {
        Self { categories: true, ..Self::default() }
    }

    /// No rule beyond one tenant for each gate.
    #[must_use]
    pub fn unlimited() -> Self {
        Self::default()
    }

    /// And one valid ticket at a time.
    #[must_use]
    pub fn with_exclusion(mut self) -> Self {
        self.exclusive = true;
        self
    }

    /// And charges within this supply.
    #[must_use]
    pub fn with_power_margin(mut self, supply: Milliwatts) -> Self {
        self.supply = Some(supply);
        self
    }

    /// And no shared conflict category.
    #[must_use]
    pub fn with_categories(mut self) -> Self {
        self.categories = true;
        self
    }

    /// And energy budgets out of this much energy: a request that asks for more
    /// than is left is refused at once.
    #[must_use]
    pub fn with_energy(mut self, energy: Microjoules) -> Self {
        self.energy = Some(energy);
        self
    }

    /// And propellant budgets out of this much propellant.
    #[must_use]
    pub fn with_propellant(mut self, propellant: Milligrams) -> Self {
        self.propellant = Some(propellant);
        self
    }
}
