//! The board: its timers, its interrupts, its memory. All that is unsafe here.
//!
//! | what | where (Arm application note AN386) | used as |
//! |---|---|---|
//! | FPGAIO counter | `0x4002_8018`, prescaled | the clock, in microseconds |
//! | TIMER0 | `0x4000_0000`, 25 MHz | counts down; three ticks and a fifth for an instruction |
//! | TIMER1 | `0x4000_1000`, interrupt 9 | the sensors' period |
//! | interrupt 31 | wired to nothing | the rescuer: pended by software |
#![expect(unsafe_code, reason = "registers are addresses, and interrupts take priorities")]

use cortex_m::Peripherals;
use cortex_m::interrupt::InterruptNumber;
use cortex_m::peripheral::scb::SystemHandler;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{NVIC, SCB};
use cortex_m_rt::exception;
use faregate_tickets::clock::Duration;
use tock_registers::interfaces::{Readable, Writeable};
use tock_registers::registers::{ReadOnly, ReadWrite};

/// The clock of both timers and of the processor.
const TICKS_PER_MICROSECOND: u32 = 25;

/// A CMSDK timer, which counts down.
#[repr(C)]
struct Timer {
    control: ReadWrite<u32>,
    value: ReadWrite<u32>,
    reload: ReadWrite<u32>,
    interrupt: ReadWrite<u32>,
}

#[repr(C)]
struct FpgaIo {
    led: ReadWrite<u32>,
    _unused: [u32; 5],
    counter: ReadOnly<u32>,
    prescale: ReadWrite<u32>,
}

const ENABLE: u32 = 1;
const ENABLE_WITH_INTERRUPT: u32 = 1 | 1 << 3;

fn timer0() -> &'static Timer {
    // SAFETY: the timer's four registers are there, for ever; they are aligned
    // words that any value may be read from.
    unsafe { &*(0x4000_0000 as *const Timer) }
}

fn timer1() -> &'static Timer {
    // SAFETY: as `timer0`.
    unsafe { &*(0x4000_1000 as *const Timer) }
}

fn fpga_io() -> &'static FpgaIo {
    // SAFETY: as `timer0`, for FPGAIO's first eight registers.
    unsafe { &*(0x4002_8000 as *const FpgaIo) }
}

/// The interrupts that are used.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Interrupt {
    /// TIMER1.
    Sensors = 9,
    /// Wired to nothing.
    Rescuer = 31,
}

// SAFETY: each variant is a number of its own below 32, as many as the board has.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}

/// Has the rescuer run when nothing more urgent does.
pub(crate) fn pend_rescuer() {
    NVIC::pend(Interrupt::Rescuer);
}

/// Has the service run when nothing more urgent does.
pub(crate) fn pend_service() {
    SCB::set_pendsv();
}

/// Starts the clock and the tick counter.
pub(crate) fn start_clocks() {
    fpga_io().prescale.set(TICKS_PER_MICROSECOND - 1);
    timer0().reload.set(u32::MAX);
    timer0().value.set(u32::MAX);
    timer0().control.set(ENABLE);
}

/// Starts the interrupts: sensors above service above rescuer above the monitor,
/// which SysTick is. Larger numbers are less urgent.
pub(crate) fn start_interrupts(mut board: Peripherals, sensors: Duration, monitor: Duration) {
    // SAFETY: no critical section here rests on priorities.
    unsafe { board.NVIC.set_priority(Interrupt::Sensors, 0x20) };
    // SAFETY: as above.
    unsafe { board.SCB.set_priority(SystemHandler::PendSV, 0x40) };
    // SAFETY: as above.
    unsafe { board.NVIC.set_priority(Interrupt::Rescuer, 0x60) };
    // SAFETY: as above.
    unsafe { board.SCB.set_priority(SystemHandler::SysTick, 0xc0) };
    // SAFETY: no critical section here rests on this interrupt being masked.
    unsafe { NVIC::unmask(Interrupt::Sensors) };
    // SAFETY: as above.
    unsafe { NVIC::unmask(Interrupt::Rescuer) };
    timer1().reload.set(ticks_in(sensors));
    timer1().value.set(ticks_in(sensors));
    timer1().control.set(ENABLE_WITH_INTERRUPT);
    board.SYST.set_clock_source(SystClkSource::Core);
    board.SYST.set_reload(ticks_in(monitor));
    board.SYST.clear_current();
    board.SYST.enable_counter();
    board.SYST.enable_interrupt();
}

fn ticks_in(period: Duration) -> u32 {
    let ticks = period.as_micros().saturating_mul(TICKS_PER_MICROSECOND.into());
    u32::try_from(ticks).unwrap_or(u32::MAX)
}

/// Microseconds since the clocks were started, modulo 2^32.
pub(crate) fn microseconds() -> u32 {
    fpga_io().counter.get()
}

/// Ticks of 40 ns that are left of 2^32.
pub(crate) fn ticks_left() -> u32 {
    timer0().value.get()
}

/// Lights the board's lamps by their bits.
pub(crate) fn light(lamps: u32) {
    fpga_io().led.set(lamps);
}

/// A hundred instructions, for the counter to be tried on.
pub(crate) fn hundred_instructions() {
    // SAFETY: does nothing.
    unsafe { core::arch::asm!(".rept 100", "nop", ".endr", options(nomem, nostack)) };
}

/// How much of the stack was ever used, and how much there is, in bytes. What
/// was never used is still painted.
pub(crate) fn most_stack() -> (usize, usize) {
    unsafe extern "C" {
        static _stack_start: u32;
        static _stack_end: u32;
    }
    let (top, end) = (&raw const _stack_start, &raw const _stack_end);
    let words = (top as usize - end as usize) / size_of::<u32>();
    let painted = (0..words).take_while(|word| {
        // SAFETY: the word lies between the stack's two ends.
        let word = unsafe { end.add(*word) };
        // SAFETY: it is memory, and aligned; that others use it is why it is
        // volatile.
        let word = unsafe { word.read_volatile() };
        word == cortex_m_rt::STACK_PAINT_VALUE
    });
    ((words - painted.count()) * size_of::<u32>(), words * size_of::<u32>())
}

#[exception]
unsafe fn DefaultHandler(interrupt: i16) {
    const SENSORS: i16 = Interrupt::Sensors as i16;
    const RESCUER: i16 = Interrupt::Rescuer as i16;
    match interrupt {
        SENSORS => {
            timer1().interrupt.set(1);
            crate::threads::sensors();
        }
        RESCUER => crate::threads::rescuer(),
        _ => crate::give_up("an interrupt came that nobody asked for"),
    }
}

#[exception]
unsafe fn HardFault(_: &cortex_m_rt::ExceptionFrame) -> ! {
    crate::give_up("the processor faulted")
}

#[exception]
fn SysTick() {
    crate::threads::monitor();
}

#[exception]
fn PendSV() {
    crate::threads::service();
}
