mod books;
use books::step::*;
use books::world::*;
#[test]
fn one() {
    let r = Rules { exclusive: false, supply: Some(10), categories: false, energy: false };
    let d = |draw| Declared { agent: 0, draw, categories: 0, settling_ms: 0, attempts: 1, safe_at_once: false, on_at_start: false };
    let setup = Setup { agents: vec![r, r], devices: vec![d(2), d(6), d(3), d(0), d(0)] };
    let ground = Ground::new(setup);
    let mut gates = ground.gates();
    let mut world = World::new(&ground, &mut gates);
    let req = |gates: &[u8], priority| Step::Request { gates: gates.to_vec(), priority, limit: Limit::None };
    for step in [req(&[2, 0], 128), req(&[1, 0], 0)] {
        eprintln!("{step:?}");
        world.apply(&step);
        world.check();
    }
    eprintln!("heal");
    world.heal_and_settle();
    eprintln!("home");
    world.go_home();
}
