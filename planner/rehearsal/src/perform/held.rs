//! Tickets that no activity has: the computer's, those of its phases, and of
//! windows; and what runs at the begin.

use faregate_devices_sim::rover::{RoverCommand, RunSpec};
use faregate_planner::parameters::Load;
use faregate_planner::state::Mode;
use faregate_planner::trace::Happened;
use faregate_planner::units::Span;

use crate::host::Host;
use crate::model::duration;
use crate::rank::{GENERATED, WINDOW};
use crate::station::{Needs, Switch};

impl Host<'_, '_, '_> {
    /// At the begin: the computer's switch, and what runs already.
    pub(crate) fn begin(&mut self) {
        self.computer.ticket = self.station.switch(Switch::Computer, GENERATED).ok();
        self.station.service();
        let mode = self.setup.state.mode;
        self.hold_phase(mode);
        let passed = self.setup.state.now.since(self.setup.state.mode_since);
        let left = |phase: Span| Span::new((phase.get() - passed.get()).max(0));
        let parameters = &self.setup.parameters;
        self.computer.pending = match mode {
            Mode::WakingUp => Some((mode, left(parameters.wakeup.duration))),
            Mode::ShuttingDown => Some((mode, left(parameters.shutdown.duration))),
            Mode::Awake | Mode::Asleep => None,
        };
        let running = self.setup.state.running.clone();
        for one in running {
            self.request(one.id);
            self.station.service();
            let Some(activity) = self.activity(one.id) else { continue };
            let left = one.ends.since(self.setup.state.now);
            let spec = self.spec(&activity, Span::new(left.get().max(1)));
            let Some(held) = self.seats.get_mut(&one.id) else { continue };
            held.started = true;
            let spec = RunSpec { place: held.seat.place, ..spec };
            self.rover.start(one.id.get(), spec);
        }
    }

    /// The computer's tickets for what it draws in this phase.
    pub(crate) fn hold_phase(&mut self, mode: Mode) {
        let parameters = &self.setup.parameters;
        let load = match mode {
            Mode::Asleep => Load::default(),
            Mode::WakingUp => parameters.wakeup.load,
            Mode::Awake => parameters.awake,
            Mode::ShuttingDown => parameters.shutdown.load,
        };
        if let Some(seat) = self.computer.phase.take() {
            self.station.release(seat);
        }
        if mode != Mode::Asleep {
            self.computer.phase = self.station.request(&generated(load)).ok();
        }
    }

    /// A wakeup or a shutdown is commanded as soon as the tickets are there.
    pub(crate) fn poll_computer(&mut self) {
        let Some((mode, takes)) = self.computer.pending else { return };
        let Some(ticket) = &self.computer.ticket else { return };
        let (wakeup, shutdown) = (duration(takes), duration(takes));
        self.rover.set_computer_times(wakeup, shutdown);
        let command = if mode == Mode::WakingUp { RoverCommand::On } else { RoverCommand::Off };
        if ticket.invoke(command).is_ok() {
            self.computer.pending = None;
        }
    }

    /// A window opens by itself: it has tickets so that nobody else is in its
    /// way.
    pub(crate) fn window(&mut self, index: usize, open: bool) {
        self.note(Happened::Window { index, open });
        if !open {
            if let Some(seat) = self.windows.remove(&index) {
                self.station.release(seat);
            }
            return;
        }
        let Some(window) = self.known.get(index) else { return };
        let needs = Needs {
            draw: window.peak,
            categories: window.resources,
            switches: Vec::new(),
            engines: window.engines,
            priority: WINDOW,
        };
        if let Ok(seat) = self.station.request(&needs) {
            self.windows.insert(index, seat);
        }
    }
}

fn generated(load: Load) -> Needs {
    Needs {
        draw: load.peak,
        categories: faregate_agents::Categories::NONE,
        switches: Vec::new(),
        engines: 0,
        priority: GENERATED,
    }
}
