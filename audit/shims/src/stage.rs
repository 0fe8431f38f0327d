//! A broker with its gates, in statics, and the ways to set it up.

use core::mem::ManuallyDrop;

use faregate_agents::{AgentId, Broker, Handle, NotYours, Policy, Revoked, Supervisor};
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::id::{HolderId, Priority};
use faregate_tickets::interlock::Member;
use faregate_tickets::notify::NoNotify;
use faregate_tickets::platform::Platform;
use faregate_tickets::refusal::{InvokeError, Refusal};
use faregate_tickets::validity::Validity;
use faregate_tickets::{Gate, Ticket};

use crate::ports::{Bare, Bench, NOW, STATUS, Setting, Word};
use crate::random::Random;
use crate::sys::Slot;

pub(crate) type Tickets<B, const G: usize, const T: usize, const S: usize> =
    Broker<'static, B, NoNotify, G, T, S>;
type Held<D, P, B, const G: usize, const T: usize, const S: usize> =
    Ticket<'static, D, P, Tickets<B, G, T, S>>;

/// Gates of the devices `D` on the platform `P`, under a broker on `B`.
///
/// The broker is last, and so nothing else's address depends on its size: on
/// x86 an address far into a static takes an instruction more.
#[derive(Debug)]
#[repr(C)]
pub(crate) struct Stage<
    D: Bench,
    P: Platform + 'static,
    B: Platform + 'static = Bare,
    const G: usize = 1,
    const T: usize = 4,
    const S: usize = 1,
> {
    gates: [Slot<Gate<'static, D, P>>; G],
    beside: Slot<Gate<'static, D, P>>,
    pub(crate) handles: [Slot<Handle<'static, D, P>>; G],
    pub(crate) agent: Slot<AgentId>,
    /// The supervisor of everything.
    pub(crate) supervisor: Slot<Supervisor>,
    /// The supervisor of the one agent.
    pub(crate) of_agent: Slot<Supervisor>,
    pub(crate) ticket: Slot<Held<D, P, B, G, T, S>>,
    pub(crate) command: Slot<Setting>,
    pub(crate) floor: Slot<Priority>,
    pub(crate) broker: Slot<Tickets<B, G, T, S>>,
}

#[expect(clippy::expect_used, reason = "a stage that cannot be set up is a defect of the audit")]
impl<D, P, B, const G: usize, const T: usize, const S: usize> Stage<D, P, B, G, T, S>
where
    D: Bench,
    P: Platform<Clock = Word, Lane: Default> + 'static,
    B: Platform<Clock = Word, Lane: Default> + 'static,
{
    pub(crate) const fn new() -> Self {
        Self {
            gates: [const { Slot::empty() }; G],
            beside: Slot::empty(),
            handles: [const { Slot::empty() }; G],
            broker: Slot::empty(),
            agent: Slot::empty(),
            supervisor: Slot::empty(),
            of_agent: Slot::empty(),
            ticket: Slot::empty(),
            command: Slot::empty(),
            floor: Slot::empty(),
        }
    }

    /// All there is, and no ticket yet.
    pub(crate) fn build(&'static self, random: &mut Random) -> &'static Tickets<B, G, T, S> {
        self.build_with(random, None)
    }

    fn build_with(
        &'static self,
        random: &mut Random,
        mut member: Option<Member<'static>>,
    ) -> &'static Tickets<B, G, T, S> {
        #[cfg(target_os = "linux")]
        crate::sys::thread::find_out();
        NOW.write(1_000_000 + random.below(1 << 40));
        STATUS.write(0);
        let mut broker = Broker::new(Word, B::Lane::default(), NoNotify);
        let supply = Milliwatts::from_watts(8_000);
        let agent = broker.agent(Policy::power_margin(supply)).expect("an agent");
        for (gate, handle) in self.gates.iter().zip(&self.handles) {
            let made = Gate::new(D::NEW, Word, P::Lane::default());
            let gate = gate.fill(match member.take() {
                Some(member) => made.interlocked(member),
                None => made,
            });
            handle.fill(broker.register(agent, gate.key()).expect("a gate"));
        }
        self.agent.fill(agent);
        self.supervisor.fill(broker.supervisor());
        self.of_agent.fill(broker.supervisor_of(agent).expect("a supervisor"));
        self.command.fill(random.pick([Setting::Off, Setting::On, Setting::Same]));
        self.floor.fill(Priority::new(random.byte()));
        self.broker.fill(broker)
    }

    /// Somebody has a ticket for the first gate, and it is valid.
    pub(crate) fn valid(&'static self, random: &mut Random) {
        self.limited(random, Validity::always());
    }

    /// Like [`Stage::valid`], with a validity function.
    pub(crate) fn limited(&'static self, random: &mut Random, validity: Validity) {
        self.build(random);
        self.admit(validity);
    }

    /// Like [`Stage::limited`], on one side of an interlock.
    pub(crate) fn interlocked(
        &'static self,
        random: &mut Random,
        member: Member<'static>,
        validity: Validity,
    ) {
        self.build_with(random, Some(member));
        self.admit(validity);
    }

    /// A gate that nobody has registered, on a side of an interlock: what its
    /// device is, is not known.
    pub(crate) fn beside(&'static self, member: Member<'static>) {
        let gate = Gate::new(D::NEW, Word, P::Lane::default());
        self.beside.fill(gate.interlocked(member));
    }

    fn admit(&'static self, validity: Validity) {
        let broker = self.broker();
        let want = self.handle().limited(validity).held_by(HolderId(7));
        let ticket = broker.request(Priority::SCIENCE, &want).expect("a ticket");
        broker.service();
        ticket.check().expect("a valid ticket");
        self.ticket.fill(ticket);
    }

    /// Somebody has a ticket for the first gate, which is not valid yet.
    pub(crate) fn requested(&'static self, random: &mut Random) {
        let broker = self.build(random);
        self.ticket.fill(broker.request(Priority::SCIENCE, self.handle()).expect("a ticket"));
    }

    /// Somebody has tickets for the first two gates, granted together.
    pub(crate) fn set(&'static self, random: &mut Random) {
        let broker = self.build(random);
        let wants = (
            self.handles[0].get().limited(Validity::always()),
            self.handles[1].get().limited(Validity::always()),
        );
        let (first, second) = broker.request(Priority::SCIENCE, &wants).expect("tickets");
        broker.service();
        first.check().expect("a valid ticket");
        self.ticket.fill(first);
        let _ = ManuallyDrop::new(second);
    }

    /// Somebody more important has the gate.
    pub(crate) fn waiting(&'static self, random: &mut Random) {
        self.valid(random);
        let rival =
            self.broker().request(Priority::EMERGENCY, &self.handle().limited(Validity::always()));
        let _ = ManuallyDrop::new(rival.expect("a ticket"));
        self.broker().service();
    }

    pub(crate) fn barred(&'static self, random: &mut Random) {
        self.valid(random);
        let id = self.ticket.get().id();
        let barred = self.broker().bar(self.supervisor.get(), id);
        barred.expect("it is here").without_waiting();
    }

    pub(crate) fn agent_revoked(&'static self, random: &mut Random) {
        self.valid(random);
        let revoked = self.broker().enter_safe_mode(self.of_agent.get(), *self.floor.get());
        revoked.expect("its agent").without_waiting();
    }

    pub(crate) fn all_revoked(&'static self, random: &mut Random) {
        self.valid(random);
        let revoked = self.broker().enter_safe_mode(self.supervisor.get(), *self.floor.get());
        revoked.expect("its broker").without_waiting();
    }

    /// The device did not obey, and its gate is closed.
    pub(crate) fn faulted(&'static self, random: &mut Random) {
        self.valid(random);
        STATUS.write(1);
        let id = self.broker().device(self.handle().gate()).and_then(|device| device.tenant);
        let barred = self.broker().bar(self.supervisor.get(), id.expect("a tenant"));
        barred.expect("it is here").without_waiting();
        // Safing finds out that the device does not obey.
        self.broker().service();
        assert!(matches!(self.ticket().check(), Err(Refusal::Faulted(_))), "a faulted gate");
    }

    /// Valid, or not for any of the reasons that there are.
    pub(crate) fn any(&'static self, seed: u64) {
        let random = &mut Random::new(seed);
        match random.below(8) {
            0 => self.waiting(random),
            1 => self.barred(random),
            2 => self.agent_revoked(random),
            3 => self.all_revoked(random),
            _ => self.valid(random),
        }
    }

    pub(crate) fn bar(&'static self) -> Result<Revoked<'static>, NotYours> {
        self.broker().bar(self.supervisor.get(), self.ticket().id())
    }

    pub(crate) fn enter_safe_mode(
        &'static self,
        supervisor: &Supervisor,
    ) -> Result<Revoked<'static>, NotYours> {
        self.broker().enter_safe_mode(supervisor, *self.floor.get())
    }

    pub(crate) fn revoke_all_but_me(&'static self) -> Result<(bool, Revoked<'static>), NotYours> {
        self.broker().revoke_all_but_me(self.supervisor.get(), self.ticket(), *self.floor.get())
    }

    /// Valid, and known to its gate from an earlier command.
    pub(crate) fn at_home(&'static self, seed: u64) {
        self.valid(&mut Random::new(seed));
        self.invoke().expect("a valid ticket");
    }

    pub(crate) fn broker(&'static self) -> &'static Tickets<B, G, T, S> {
        self.broker.get()
    }

    pub(crate) fn handle(&'static self) -> &'static Handle<'static, D, P> {
        self.handles[0].get()
    }

    #[inline(always)]
    pub(crate) fn invoke(&'static self) -> Result<(), InvokeError<()>> {
        self.ticket().invoke(*self.command.get())
    }

    #[inline(always)]
    pub(crate) fn try_invoke(&'static self) -> Result<(), InvokeError<()>> {
        self.ticket().try_invoke(*self.command.get())
    }

    pub(crate) fn ticket(&'static self) -> &'static Held<D, P, B, G, T, S> {
        self.ticket.get()
    }
}
