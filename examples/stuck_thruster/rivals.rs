//! The three designs that the paper shows to fail, each as well as it can be
//! done: commands are repeated until a fresh estimate confirms them.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use faregate::tickets::clock::{Clock, Duration, Instant};
use faregate::tickets::id::Priority;
use faregate_devices_sim::{CameraCommand, CutoffCommand, Spacecraft};

use crate::bodies;
use crate::design::Rival;
use crate::flight::{Flight, is_shut_command};
use crate::scene::{Monitor, Scene};
use crate::stage::{Body, Stage};
use crate::tape::Tape;
use crate::watch::Watch;

/// How long the monitor may be kept from running: its other duties are
/// time-critical. It is enough for the emergency when every command works the
/// first time.
const LONGEST_SUSPENSION: Duration = Duration::from_millis(200);

struct World<'w> {
    stage: &'w Stage,
    scene: &'w Scene,
    craft: &'w Spacecraft,
    watch: &'w Watch,
    rival: Rival,
    /// Until when the monitor is suspended.
    suspended: Mutex<Option<Instant>>,
    /// Whether the monitor's power allocation is valid.
    allocated: AtomicBool,
    requested: Mutex<Option<Instant>>,
}

/// Flies one scene without tickets.
pub(crate) fn fly(scene: &Scene, rival: Rival, stage: &Stage, tape: &Tape) -> Flight {
    let craft =
        Spacecraft::new(scene.parameters.clone(), scene.script.clone(), scene.seed, &stage.clock);
    let watch = Watch::new(&craft, stage.teller());
    let world = World {
        stage,
        scene,
        craft: &craft,
        watch: &watch,
        rival,
        suspended: Mutex::default(),
        allocated: AtomicBool::new(true),
        requested: Mutex::default(),
    };
    let mut threads: Vec<Body<'_>> = vec![
        ("rescuer", Priority::EMERGENCY, Box::new(|| world.rescuer())),
        ("director", Priority::LEAST, Box::new(|| bodies::director(stage, scene, &craft, tape))),
    ];
    if let Some(monitor) = scene.monitor {
        threads.push((
            "monitor",
            Priority::SCIENCE,
            Box::new({
                let world = &world;
                move || world.monitor(monitor)
            }),
        ));
    }
    stage.perform(scene.seed, threads);
    world.result(tape)
}

impl World<'_> {
    fn monitor(&self, monitor: Monitor) {
        let camera = self.craft.bare_camera();
        bodies::camera_monitor(self.stage, self.craft, monitor, |command| match self.rival {
            Rival::BareCommands => camera.issue(command).is_ok(),
            Rival::SuspendedMonitor => {
                self.stay_suspended();
                camera.issue(command).is_ok()
            }
            Rival::Convention => {
                // The paper's last listing: the allocation is checked, and some
                // time later the command is issued.
                let valid = self.allocated.load(Ordering::SeqCst);
                self.stage.wait(monitor.window);
                valid && camera.issue(command).is_ok()
            }
        });
    }

    fn stay_suspended(&self) {
        let until = *self.suspended.lock().expect("nobody panics");
        if let Some(until) = until {
            self.stage.clock.wait_until(until);
        }
    }

    fn rescuer(&self) {
        if !bodies::wait_for_spin(self.stage, self.craft, 10_000) {
            return;
        }
        let now = self.stage.clock.now();
        *self.requested.lock().expect("nobody panics") = Some(now);
        self.stage.tell("rescuer", || "the body spins: turns the camera off".into());
        match self.rival {
            Rival::BareCommands => {}
            Rival::SuspendedMonitor => {
                *self.suspended.lock().expect("nobody panics") =
                    Some(now.after(LONGEST_SUSPENSION));
            }
            Rival::Convention => self.allocated.store(false, Ordering::SeqCst),
        }
        let camera = self.craft.bare_camera();
        bodies::camera_off_for_sure(self.stage, self.scene, self.craft, || {
            let _ = camera.issue(CameraCommand::Off);
        });
        self.watch.close_door();
        self.stage.tell("rescuer", || "has seen the camera off; commands the valve shut".into());
        let cutoff = self.craft.bare_cutoff();
        bodies::shut_for_sure(self.stage, self.scene, self.craft, || {
            cutoff.issue(CutoffCommand::Shut).is_ok()
        });
        self.watch.open_door();
        // The allocation comes back when the coil has had its pulse.
        self.stage.wait(self.scene.parameters.cutoff_pulse);
        self.allocated.store(true, Ordering::SeqCst);
    }

    fn result(&self, tape: &Tape) -> Flight {
        let trace = self.craft.trace();
        let shut = trace.iter().find(|entry| is_shut_command(entry));
        let requested = *self.requested.lock().expect("nobody panics");
        Flight {
            after_quiescence: self.watch.passed(),
            cutoff_after: shut.zip(requested).map(|(shut, at)| shut.begun.since(at)),
            ..Flight::of(self.scene, self.craft, tape)
        }
    }
}
