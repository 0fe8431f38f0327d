//! A transmitter: what it sends counts only while a radio window is open.

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Duration, Instant};

use super::radio::RadioWindows;
use super::settings::Settings;
use super::unit::{Action, CommandHelp, Made, Switch, Unit, later};

/// On, and the amplifier idle.
const STANDBY: Milliwatts = Milliwatts::from_watts(4);
/// Sending: an S-band transmitter of a few watts radiated.
const SENDING: Milliwatts = Milliwatts::from_watts(15);
/// Kibibytes in a second: 1 Mbit/s.
const RATE: u64 = 122;

pub(crate) const COMMANDS: &[CommandHelp] = &[
    CommandHelp::plain("on", "switch the transmitter on, silent"),
    CommandHelp::plain("off", "switch it off; what was not sent stays on board"),
    CommandHelp::with("send", "KIB", "send so many kibibytes; none arrive outside a radio window"),
];

#[derive(Clone, Debug)]
pub(crate) struct Transmitter {
    switch: Switch,
    standby: Milliwatts,
    sending: Milliwatts,
    /// Kibibytes in a second.
    rate: u64,
    windows: RadioWindows,
    sending_until: Option<Instant>,
    /// Since when the present rate of arrival holds.
    since: Instant,
    /// Kibibytes times microseconds per second, so that no rounding adds up.
    arrived: u128,
    lost: u128,
}

impl Transmitter {
    pub(crate) fn read(settings: &mut Settings<'_>) -> (Self, Milliwatts) {
        let standby = settings.watts("standby_w", STANDBY);
        let sending = settings.watts("sending_w", SENDING).max(standby);
        let transmitter = Self {
            switch: Switch::OPEN,
            standby,
            sending,
            rate: settings.number("rate_kib_s", RATE).max(1),
            windows: settings
                .spans("windows_s")
                .map_or_else(RadioWindows::always, RadioWindows::new),
            sending_until: None,
            since: Instant::START,
            arrived: 0,
            lost: 0,
        };
        (transmitter, sending)
    }

    /// What went out since `self.since`: arrived, lost.
    fn sent(&self, now: Instant) -> (u128, u128) {
        let Some(until) = self.sending_until else { return (0, 0) };
        let time = now.min(until).since(self.since).as_micros();
        let sent = u128::from(time) * u128::from(self.rate);
        if self.windows.is_open(self.since) { (sent, 0) } else { (0, sent) }
    }

    fn count(&mut self, now: Instant) {
        let (arrived, lost) = self.sent(now);
        self.arrived += arrived;
        self.lost += lost;
        self.since = now;
    }

    fn send(&mut self, kib: u32, now: Instant) -> bool {
        let can = self.switch.is_closed() && self.sending_until.is_none();
        if can {
            let time = Duration::from_micros(u64::from(kib) * 1_000_000 / self.rate);
            self.sending_until = Some(later(now, time));
        }
        can
    }
}

impl Unit for Transmitter {
    fn is_on(&self) -> bool {
        self.switch.is_closed()
    }

    fn draw(&self, _: Instant) -> Milliwatts {
        let sends = self.sending_until.is_some();
        self.switch.drawing(if sends { self.sending } else { self.standby })
    }

    fn next_event(&self, now: Instant) -> Option<Instant> {
        let until = self.sending_until?;
        Some(self.windows.next_change(now).map_or(until, |change| change.min(until)))
    }

    fn happen(&mut self, now: Instant) {
        self.count(now);
        self.sending_until.take_if(|until| *until <= now);
    }

    fn react(&mut self, action: Action, now: Instant) -> bool {
        self.count(now);
        match action {
            Action::On => self.switch.set(true),
            Action::Off => {
                self.sending_until = None;
                self.switch.set(false)
            }
            Action::Send(kib) => self.send(kib, now),
            _ => false,
        }
    }

    fn made(&self, now: Instant) -> Made {
        let (arrived, lost) = self.sent(now);
        let kib = |sum: u128| u64::try_from(sum / 1_000_000).unwrap_or(u64::MAX);
        Made { finished: kib(self.arrived + arrived), lost: kib(self.lost + lost) }
    }
}
