mod agents;mod drive; mod gates; mod place; mod rivals; mod room; mod subject;
use std::sync::atomic::AtomicU64;
use drive::*; use place::*;
use faregate::runtime::host::HostStrategy;
use faregate::tickets::lock::Locked;
type Pl = Locked<parking_lot::RawMutex, parking_lot::RawThreadId>;
fn main() {
    let n: u64 = std::env::args().nth(1).map_or(100_000, |n| n.parse().unwrap());
    for place in [Place::AllCores, one_cpu().unwrap()] {
        let d = Drive { place, revocations: n, seed: 1, skip_quiescence: false };
        let run = |name: &str, f: &dyn Fn() -> subject::Outcome<Tally>| {
            let t = std::time::Instant::now();
            let r = f();
            let s = t.elapsed().as_secs_f64();
            match r { Ok(t) => println!("{name} {place:?} {:.0}/s {t:?} {:.1}%", n as f64 / s, t.admitted_percent()), Err(e) => println!("{name} {place:?} ERR {e}") }
        };
        run("pi", &|| d.soak(gates::Gates::<HostStrategy>::new()?, &AtomicU64::new(0)));
        run("pl", &|| d.soak(gates::Gates::<Pl>::new()?, &AtomicU64::new(0)));
        run("agents pi", &|| d.soak(agents::ByHand::<HostStrategy>::new()?, &AtomicU64::new(0)));
        run("agents pl", &|| d.soak(agents::ByHand::<Pl>::new()?, &AtomicU64::new(0)));
        run("service pi", &|| d.soak(agents::WithService::new()?, &AtomicU64::new(0)));
        run("bare", &|| d.soak(rivals::Flags::new(rivals::Flagged::Bare), &AtomicU64::new(0)));
        run("outside", &|| d.soak(rivals::Flags::new(rivals::Flagged::OutsideTheLock), &AtomicU64::new(0)));
        let d = Drive { skip_quiescence: true, ..d };
        run("pi skip", &|| d.soak(gates::Gates::<HostStrategy>::new()?, &AtomicU64::new(0)));
        run("pl skip", &|| d.soak(gates::Gates::<Pl>::new()?, &AtomicU64::new(0)));
    }
}
