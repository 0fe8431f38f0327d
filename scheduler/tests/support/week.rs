//! A week of an Earth-observing satellite: 7 800 activities, as EO-1 flew them.

use faregate_agents::Categories;
use faregate_scheduler::TaskId;
use faregate_scheduler::mission::{AgentSpec, Mission};
use faregate_scheduler::task::{Body, Task, TaskPriority, When, Window};
use faregate_scheduler::time::Duration;
use faregate_tickets::amount::Milliwatts;

/// Seconds of an orbit, and how many of them are in a week.
const ORBIT: u64 = 5_933;
const ORBITS: u64 = 102;
/// Scenes of an orbit, and what belongs to a scene.
const SCENES: u64 = 12;
const ACTIVITIES: [Activity; 6] = [
    Activity { name: "slew", after: 0, takes: 90, mask: 0b1, priority: 30, draw: 12 },
    Activity { name: "warm up", after: 40, takes: 60, mask: 0b10, priority: 28, draw: 8 },
    Activity { name: "image", after: 100, takes: 16, mask: 0b111, priority: 40, draw: 20 },
    Activity { name: "calibrate", after: 120, takes: 20, mask: 0b10, priority: 25, draw: 8 },
    Activity { name: "detect clouds", after: 150, takes: 120, mask: 0b1000, priority: 10, draw: 9 },
    Activity { name: "compress", after: 290, takes: 60, mask: 0b1000, priority: 12, draw: 9 },
];

struct Activity {
    name: &'static str,
    after: u64,
    takes: u64,
    mask: u128,
    priority: u8,
    draw: u32,
}

/// How many activities are planned.
pub(crate) const PLANNED: usize = 7_800;

pub(crate) fn mission() -> Mission {
    Mission {
        agents: vec![AgentSpec { name: "bus".into(), supply: Some(Milliwatts::from_watts(45)) }],
        ..Mission::default()
    }
}

/// Twelve scenes of six activities each orbit, four passes over ground stations
/// each orbit, and what is left is housekeeping.
pub(crate) fn tasks() -> Vec<Task> {
    let scenes = (0..ORBITS).flat_map(|orbit| {
        (0..SCENES).flat_map(move |scene| {
            let begins = orbit * ORBIT + 120 + scene * 440;
            ACTIVITIES.iter().map(move |activity| (begins, activity))
        })
    });
    let scenes = scenes.map(|(begins, activity)| activity.at(begins));
    let passes = (0..ORBITS * 4).map(|pass| DOWNLINK.at(pass * ORBIT / 4 + 700));
    let keeping = (0..).map(|hour| KEEPING.at(hour * 3_600 / 10 + 17));
    let numbered = scenes.chain(passes).chain(keeping).zip(1..).take(PLANNED);
    numbered.map(|(task, number)| Task { id: id(number), ..task }).collect()
}

fn id(number: u32) -> TaskId {
    TaskId::new(number).expect("tasks count from 1")
}

const fn s(seconds: u64) -> Duration {
    Duration::from_secs(seconds)
}

const DOWNLINK: Activity =
    Activity { name: "downlink", after: 0, takes: 480, mask: 0b1_0001, priority: 60, draw: 18 };
const KEEPING: Activity =
    Activity { name: "housekeeping", after: 0, takes: 30, mask: 0b1000, priority: 5, draw: 4 };

impl Activity {
    /// May start until ten minutes later.
    fn at(&self, begins: u64) -> Task {
        let mut task = Task::new(id(1), Body::Hold);
        let opens = When::AfterLoad(s(begins + self.after));
        let closes = When::AfterLoad(s(begins + self.after + 600));
        task.name = Some(self.name.into());
        task.windows = vec![Window { opens, closes }];
        task.duration = s(self.takes);
        task.categories = Categories::from_mask(self.mask);
        task.priority = TaskPriority::new(self.priority).unwrap();
        task.peak_draw = Milliwatts::from_watts(self.draw);
        task
    }
}

/// The week is over then.
pub(crate) const ENDS: Duration = s(7 * 86_400);
