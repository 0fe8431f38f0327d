use faregate_devices_sim::interleave::SimLocked;

use super::{Panel, draw};
use crate::design::{Design, Rival};
use crate::flight::Flight;
use crate::scene::Scene;
use crate::stage::Stage;
use crate::tape::Tape;
use crate::tickets::Variant;

const TICKETS: Design = Design::Tickets(Variant::PowerMargin);
const BARE: Design = Design::Rival(Rival::BareCommands);

fn flown(design: Design, tape: &Tape) -> Flight {
    let scene = Scene::demonstration(1);
    design.fly::<SimLocked>(&scene, &Stage::virtual_time(scene.ends_at), tape)
}

fn drawn(designs: [Design; 2]) -> String {
    let scene = Scene::demonstration(1);
    let flights = designs.map(|design| (design.name(), flown(design, &Tape::on())));
    let [left, right] =
        flights.each_ref().map(|(title, flight)| Panel { title, flight, scene: &scene });
    draw(&left, &right).unwrap()
}

#[test]
fn the_same_scene_gives_the_same_picture() {
    assert_eq!(drawn([TICKETS, BARE]), drawn([TICKETS, BARE]));
}

#[test]
fn a_tripped_bus_is_crossed_and_a_saved_one_is_not() {
    assert_eq!(drawn([TICKETS, BARE]).matches("bus trip\n").count(), 1);
    assert_eq!(drawn([TICKETS, TICKETS]).matches("bus trip\n").count(), 0);
}

#[test]
fn holders_are_named_and_a_rival_has_none() {
    let (both, rivals) = (drawn([TICKETS, BARE]), drawn([BARE, BARE]));
    assert!(both.contains("monitor\n") && both.contains("rescuer\n"));
    assert!(!rivals.contains("monitor\n") && !rivals.contains("rescuer\n"));
    assert_eq!(both.matches("no tickets").count(), 1);
    assert_eq!(rivals.matches("no tickets").count(), 2);
}

#[test]
fn a_flight_without_samples_is_not_drawn() {
    let scene = Scene::demonstration(1);
    let (taped, untaped) = (flown(TICKETS, &Tape::on()), flown(BARE, &Tape::off()));
    let panel = |flight| Panel { title: "a flight", flight, scene: &scene };
    assert!(draw(&panel(&taped), &panel(&taped)).is_ok());
    assert!(draw(&panel(&taped), &panel(&untaped)).is_err());
}
