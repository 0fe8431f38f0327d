//! Lists of wants: sets whose size is known at run time.

use faregate_tickets::device::Device;
use faregate_tickets::id::Priority;
use faregate_tickets::notify::Notify;
use faregate_tickets::platform::Platform;
use faregate_tickets::ticket::Ticket;

use crate::books::Ask;
use crate::refusal::RequestRefused;

use super::{Broker, Seated, Want, Wants};

impl<
    'b,
    'g: 'b,
    D: Device,
    Q: Platform,
    P: Platform + 'b,
    N: Notify + 'b,
    const G: usize,
    const T: usize,
    const S: usize,
    const M: usize,
> Wants<'b, 'g, P, N, G, T, S> for heapless::Vec<Want<'g, D, Q>, M>
{
    type Tickets = heapless::Vec<Ticket<'b, D, Q, Broker<'g, P, N, G, T, S>>, M>;

    fn ask(
        &self,
        broker: &Broker<'g, P, N, G, T, S>,
        priority: Priority,
    ) -> Result<Ask, RequestRefused> {
        let (first, rest) = self.split_first().ok_or(RequestRefused::NoGate)?;
        and_each(first.ask(broker, priority)?, broker, rest)
    }

    fn tickets(
        &self,
        broker: &'b Broker<'g, P, N, G, T, S>,
        seated: &Seated,
    ) -> Option<Self::Tickets> {
        self.iter().map(|want| broker.ticket(&want.handle, seated.0)).collect()
    }
}

/// One gate, and as many of another kind as the list has: none, too.
impl<
    'b,
    'g: 'b,
    C: Device,
    R: Platform,
    D: Device,
    Q: Platform,
    P: Platform + 'b,
    N: Notify + 'b,
    const G: usize,
    const T: usize,
    const S: usize,
    const M: usize,
> Wants<'b, 'g, P, N, G, T, S> for (Want<'g, C, R>, heapless::Vec<Want<'g, D, Q>, M>)
{
    type Tickets = (
        Ticket<'b, C, R, Broker<'g, P, N, G, T, S>>,
        heapless::Vec<Ticket<'b, D, Q, Broker<'g, P, N, G, T, S>>, M>,
    );

    fn ask(
        &self,
        broker: &Broker<'g, P, N, G, T, S>,
        priority: Priority,
    ) -> Result<Ask, RequestRefused> {
        and_each(self.0.ask(broker, priority)?, broker, &self.1)
    }

    fn tickets(
        &self,
        broker: &'b Broker<'g, P, N, G, T, S>,
        seated: &Seated,
    ) -> Option<Self::Tickets> {
        let others = self.1.iter().map(|want| broker.ticket(&want.handle, seated.0));
        Some((broker.ticket(&self.0.handle, seated.0)?, others.collect::<Option<_>>()?))
    }
}

fn and_each<'g, D: Device, Q: Platform, P, N, const G: usize, const T: usize, const S: usize>(
    ask: Ask,
    broker: &Broker<'g, P, N, G, T, S>,
    wants: &[Want<'g, D, Q>],
) -> Result<Ask, RequestRefused>
where
    P: Platform,
    N: Notify,
{
    wants.iter().try_fold(ask, |ask, want| ask.and(broker.known(&want.handle)?, want.validity))
}
