//! One emergency after the other at one broker: the cutoff valve is needed, the
//! supply does not suffice, the least important camera has to go.

use std::time::{Duration, Instant};

use faregate_runtime::clock::MonotonicClock;
use faregate_tickets::clock::{Clock, Duration as Bound};
use faregate_tickets::id::Priority;
use faregate_tickets::notify::Notify;

use crate::agency::{Agency, Agents, Handle, TIMEOUT, Ticket};
use crate::sensors::{self, Sensing};
use crate::support::Failure;

/// A broker, its cameras' tickets, all valid and their cameras on.
pub(crate) struct Rescue<N, const G: usize, const T: usize, const S: usize>
where
    N: Notify + 'static,
{
    agency: Agency<Agents<N, G, T, S>>,
    cameras: Vec<Ticket<Agents<N, G, T, S>>>,
    cutoff: Handle,
    /// Others in line for the victim's camera, behind it.
    _crowd: Vec<Ticket<Agents<N, G, T, S>>>,
}

impl<N, const G: usize, const T: usize, const S: usize> Rescue<N, G, T, S>
where
    N: Notify + Send + 'static,
{
    /// Tickets for all cameras, and as many more in line for the first one as
    /// makes so many.
    pub(crate) fn new(
        agency: Agency<Agents<N, G, T, S>>,
        sensing: Sensing,
        tickets: usize,
    ) -> Result<Self, Failure> {
        sensors::start(&agency, sensing)?;
        let mut cameras = agency.devices.clone();
        let cutoff = cameras.pop().ok_or("there is no cutoff valve")?;
        let crowd = tickets.saturating_sub(cameras.len());
        let request = |level, camera: &Handle| agency.agents.request(Priority::new(level), camera);
        // The first is the least important, and so the victim.
        let levels = std::iter::once(2).chain(std::iter::repeat(64));
        let held: Result<_, _> = levels.zip(&cameras).map(|(level, c)| request(level, c)).collect();
        let crowd: Result<_, _> = (0..crowd).map(|_| request(1, &cameras[0])).collect();
        let rescue = Self { cameras: held?, _crowd: crowd?, cutoff, agency };
        rescue.restore()?;
        Ok(rescue)
    }

    /// Request, pre-empt, quiesce, safe, see off, admit, command: measured. Then
    /// all is put back.
    pub(crate) fn round(&self, failures: u32) -> Result<Duration, Failure> {
        self.agency.plant.deafen(failures);
        let start = Instant::now();
        let emergency = self.agency.agents.request(Priority::EMERGENCY, &self.cutoff)?;
        (self.agency.wait)(&emergency)?;
        emergency.invoke(true).map_err(|error| format!("the cutoff: {error:?}"))?;
        let took = start.elapsed();
        self.inspect()?;
        emergency.invoke(false).map_err(|error| format!("the cutoff: {error:?}"))?;
        drop(emergency);
        self.restore()?;
        Ok(took)
    }

    /// One camera was taken, the least important, and is off; nobody else was.
    fn inspect(&self) -> Result<(), Failure> {
        let valid = self.cameras.iter().filter(|ticket| ticket.check().is_ok()).count();
        let on = |gate| self.agency.plant.is_on(gate);
        let off = !on(self.agency.devices[0].gate());
        let found = (valid, off, on(self.cutoff.gate()));
        if found == (self.cameras.len() - 1, true, true) {
            return Ok(());
        }
        Err(format!("cameras valid, the victim off, the cutoff on: {found:?}").into())
    }

    /// Until every camera is on again, the cutoff valve being seen off.
    fn restore(&self) -> Result<(), Failure> {
        let clock = MonotonicClock::new();
        let deadline = clock.now().after(TIMEOUT);
        let agents = self.agency.agents;
        while self.cameras.iter().any(|camera| camera.check().is_err()) {
            for device in &self.agency.devices {
                agents.observe(device.gate(), self.agency.plant.measure(device.gate()));
            }
            agents.service();
            if clock.now() > deadline {
                return Err("the cameras' tickets were not restored".into());
            }
        }
        for camera in &self.cameras {
            camera.invoke(true).map_err(|error| format!("a camera: {error:?}"))?;
        }
        Ok(())
    }

    /// The computed bound of this emergency, in one round of victims.
    pub(crate) fn bound(&self) -> Option<Bound> {
        self.agency.agents.hand_over_bound(self.cutoff.gate(), 1)
    }
}
