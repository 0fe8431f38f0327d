//! The first ticket: one device, and two who want it.
//!
//! A survey turns a camera on through its ticket. Then somebody more important
//! asks for the same camera: the survey's ticket still exists, and refuses, and
//! says why. When the other ticket is given back, the survey's is valid again,
//! without anybody asking for it.
//!
//! ```sh
//! cargo run --example first_ticket
//! ```

use std::error::Error;

use faregate::prelude::*;

const SECOND: Duration = Duration::from_secs(1);

fn main() -> Result<(), Box<dyn Error>> {
    let mut builder = Broker::builder()?;
    let agent = builder.agent(Policy::exclusive())?;
    let camera = builder.gate(agent, "camera", Camera)?;
    let broker = builder.start()?;

    println!("The survey requests a ticket, waits until it is valid, and uses it:");
    let survey = broker.request(Priority::SCIENCE, &camera)?;
    broker.wait(&survey, SECOND)?;
    survey.invoke(Power::On)?;

    println!("Navigation is more important, and requests the same:");
    let navigation = broker.request(Priority::ENGINEERING, &camera)?;
    broker.wait(&navigation, SECOND)?;
    navigation.invoke(Power::Off)?;

    println!("The survey finds its camera off, and commands it on:");
    let Err(refused) = survey.invoke(Power::On) else {
        return Err("a ticket that had been taken was admitted".into());
    };
    println!("    refused: {refused}");
    let by = Why::Preempted { by: navigation.id(), priority: Priority::ENGINEERING };
    if refused.refusal() != Some(Refusal::NotValid(by)) {
        return Err("the refusal does not name who took the camera".into());
    }

    println!("Navigation is done, and relinquishes. The survey just goes on:");
    navigation.relinquish();
    broker.wait(&survey, SECOND)?;
    survey.invoke(Power::On)?;
    Ok(())
}

/// The camera's driver. It is moved into its gate, and nobody has another.
struct Camera;

#[derive(Clone, Copy, Debug)]
enum Power {
    On,
    Off,
}

impl Device for Camera {
    type Command = Power;
    type Response = ();
    type Fault = ();

    fn profile(&self) -> Profile {
        Profile::new()
    }

    fn declare(command: &Power) -> Declaration {
        let (code, effect) = match command {
            Power::On => (1, Effect::on(Milliwatts::ZERO)),
            Power::Off => (2, Effect::Off),
        };
        Declaration { code, wcet: Duration::from_millis(1), effect }
    }

    fn issue(&mut self, command: Power) -> Result<(), ()> {
        println!("    the camera is told: {command:?}");
        Ok(())
    }

    fn safe(&mut self) -> Result<(), ()> {
        self.issue(Power::Off)
    }
}
