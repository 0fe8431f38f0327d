//! The schedule that is run in each history: every kind of restart, starts that
//! are armed and starts that are not, a pre-emption, a routine task, a device.

use std::path::Path;

use faregate_agents::Categories;
use faregate_scheduler::Mission;
use faregate_scheduler::mission::{AgentSpec, DeviceSpec};
use faregate_scheduler::task::{Body, Restart, Task, TaskId, TaskPriority, When, Window};
use faregate_scheduler::time::Duration;
use faregate_tickets::amount::Milliwatts;

use crate::Failure;
use crate::device::CAMERA;

/// What distinguishes the tasks.
struct Plan {
    id: u32,
    starts_ms: u64,
    takes_ms: u64,
    camera: bool,
    again: bool,
    priority: u8,
}

const PLANS: [Plan; 8] = [
    Plan { id: 1, starts_ms: 0, takes_ms: 20, camera: false, again: false, priority: 1 },
    Plan { id: 2, starts_ms: 100, takes_ms: 150, camera: true, again: false, priority: 1 },
    // Takes the camera and the category from the one before.
    Plan { id: 3, starts_ms: 180, takes_ms: 40, camera: true, again: true, priority: 9 },
    Plan { id: 4, starts_ms: 60, takes_ms: 60, camera: false, again: true, priority: 1 },
    Plan { id: 5, starts_ms: 250, takes_ms: 20, camera: false, again: false, priority: 1 },
    Plan { id: 6, starts_ms: 400, takes_ms: 30, camera: true, again: false, priority: 1 },
    Plan { id: 7, starts_ms: 430, takes_ms: 20, camera: false, again: true, priority: 1 },
    Plan { id: 8, starts_ms: 500, takes_ms: 20, camera: false, again: false, priority: 1 },
];

/// Starts a process that it does not wait for.
const LEAVES: u32 = 4;

/// Runs as long as the manager does, every so often.
pub(crate) const ROUTINE: u32 = 9;
pub(crate) const INTERVAL: Duration = Duration::from_millis(120);

/// All tasks; their processes are this program.
pub(crate) fn tasks(place: &Path) -> Result<Vec<Task>, Failure> {
    let mut tasks = PLANS.iter().map(|plan| task(plan, place)).collect::<Result<Vec<_>, _>>()?;
    let plan =
        Plan { id: ROUTINE, starts_ms: 50, takes_ms: 10, camera: false, again: false, priority: 1 };
    tasks.push(Task { interval: Some(INTERVAL), ..task(&plan, place)? });
    Ok(tasks)
}

fn task(plan: &Plan, place: &Path) -> Result<Task, Failure> {
    let id = TaskId::new(plan.id).ok_or("0 is not a task")?;
    let own = std::env::current_exe()?.to_string_lossy().into_owned();
    let place = place.to_string_lossy().into_owned();
    let mut arguments = vec!["task".into(), place, "--takes".into(), plan.takes_ms.to_string()];
    if plan.camera {
        arguments.push("--camera".into());
    }
    if plan.id == LEAVES {
        arguments.push("--leaves".into());
    }
    let opens = match plan.starts_ms {
        0 => When::Unrestricted,
        ms => When::AfterLoad(Duration::from_millis(ms)),
    };
    let again = Restart::OnFailure { limit: 1_000, back_off: Duration::from_millis(10) };
    let conflict = if plan.camera { Categories::from_mask(1) } else { Categories::NONE };
    Ok(Task {
        windows: vec![Window { opens, closes: When::Unrestricted }],
        categories: conflict,
        priority: TaskPriority::new(plan.priority).ok_or("it is a task's priority")?,
        restart: if plan.again { again } else { Restart::Never },
        gates: if plan.camera { vec![CAMERA.into()] } else { Vec::new() },
        ..Task::new(id, Body::Process { program: own, arguments })
    })
}

/// One agent with power for the camera.
pub(crate) fn mission() -> Mission {
    let supply = Some(Milliwatts::from_watts(10));
    let agents = vec![AgentSpec { name: "power".into(), supply }];
    let devices = vec![camera()];
    Mission { agents, devices, lease: Duration::from_secs(20), ..Mission::default() }
}

pub(crate) fn camera() -> DeviceSpec {
    DeviceSpec {
        name: CAMERA.into(),
        kind: CAMERA.into(),
        agent: "power".into(),
        draw: None,
        categories: Categories::NONE,
        parameters: Default::default(),
    }
}
