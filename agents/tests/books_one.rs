mod books;
use books::step::*;
use books::world::*;
#[test]
fn one() {
    let r = |exclusive| Rules { exclusive, supply: None, categories: false, energy: false };
    let d = |draw| Declared { agent: 0, draw, categories: 0, settling_ms: 0, attempts: 1, safe_at_once: false, on_at_start: false };
    let setup = Setup { agents: vec![r(true), r(false)], devices: vec![d(0), d(0), d(0), d(0), d(0)] };
    let ground = Ground::new(setup);
    let mut gates = ground.gates();
    let mut world = World::new(&ground, &mut gates);
    let req = |gates: &[u8], priority| Step::Request { gates: gates.to_vec(), priority, limit: Limit::None };
    for step in [req(&[0], 0), req(&[0], 0), Step::Hang{gate: 0, hung: true}, req(&[1], 0), req(&[0],0), Step::Settle] {
        eprintln!("{step:?}");
        world.apply(&step);
        world.check();
    }
    world.heal_and_settle();
    world.go_home();
}
