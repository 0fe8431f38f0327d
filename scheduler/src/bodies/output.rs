//! What processes print: the end of it is kept, the rest is counted.
//!
//! A thread of its own reads the pipes. A task that prints without end takes
//! processor time from that thread, and none from the manager's.

use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::os::fd::OwnedFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

use parking_lot::Mutex;
use rustix::buffer::spare_capacity;
use rustix::event::epoll;
use rustix::fs::{OFlags, fcntl_setfl};
use rustix::io::Errno;
use rustix::pipe::fcntl_getpipe_size;

use crate::executive::Waker;

/// The bell among the pipes.
const BELL: u64 = u64::MAX;

/// How much of one pipe is read before others have their turn.
const TURN: usize = 64 * 1024;

/// What an attempt has printed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Output {
    /// To its standard output.
    pub stdout: Printed,
    /// To its standard error.
    pub stderr: Printed,
}

/// What was printed to one of the two.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Printed {
    /// The end of it, as much as is kept.
    pub tail: Vec<u8>,
    /// How many bytes came before, and were not kept.
    pub dropped: u64,
}

/// The two pipes of an attempt, shared with the thread that reads them.
#[derive(Clone, Debug)]
pub(super) struct Capture {
    desk: Arc<Desk>,
    pipes: [(u64, Arc<Mutex<Pipe>>); 2],
}

impl Capture {
    /// What was printed up to now, whatever the thread has come to.
    pub(super) fn so_far(&self) -> Output {
        let [stdout, stderr] = self.pipes.each_ref().map(|(_, pipe)| {
            let mut pipe = pipe.lock();
            pipe.drain();
            pipe.printed()
        });
        Output { stdout, stderr }
    }

    /// Nobody prints any more.
    pub(super) fn finish(&self) -> Output {
        let output = self.so_far();
        for (token, pipe) in &self.pipes {
            self.desk.close(*token, &mut pipe.lock());
        }
        output
    }
}

#[derive(Debug)]
struct Pipe {
    source: Option<OwnedFd>,
    /// Nobody can write to it any more.
    ended: bool,
    tail: VecDeque<u8>,
    dropped: u64,
    limit: usize,
    buffer: Vec<u8>,
}

impl Pipe {
    fn new(source: OwnedFd, limit: usize) -> Self {
        Self {
            source: Some(source),
            ended: false,
            tail: VecDeque::new(),
            dropped: 0,
            limit,
            buffer: Vec::new(),
        }
    }

    /// Reads what is in it: at most what it can hold, however fast it is filled
    /// again. A task may have made it larger.
    fn drain(&mut self) {
        let holds = self.source.as_ref().and_then(|source| fcntl_getpipe_size(source).ok());
        self.read(holds.map_or(TURN, |holds| holds.max(TURN)));
    }

    fn read(&mut self, limit: usize) {
        let mut taken = 0;
        while taken < limit && !self.ended {
            let Some(source) = &self.source else { return };
            self.buffer.clear();
            self.buffer.reserve(16 * 1024);
            match rustix::io::read(source, spare_capacity(&mut self.buffer)) {
                Ok(0) => self.ended = true,
                Ok(length) => {
                    taken += length;
                    self.keep();
                }
                Err(Errno::INTR) => {}
                Err(Errno::AGAIN) => return,
                Err(_) => self.ended = true,
            }
        }
    }

    fn keep(&mut self) {
        self.tail.extend(&self.buffer);
        let excess = self.tail.len().saturating_sub(self.limit);
        self.tail.drain(..excess);
        self.dropped += u64::try_from(excess).unwrap_or(0);
    }

    fn printed(&self) -> Printed {
        Printed { tail: self.tail.iter().copied().collect(), dropped: self.dropped }
    }
}

/// The thread that reads.
#[derive(Debug)]
pub(super) struct Scribe {
    desk: Arc<Desk>,
    limit: usize,
    next: u64,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug)]
struct Desk {
    epoll: OwnedFd,
    pipes: Mutex<BTreeMap<u64, Arc<Mutex<Pipe>>>>,
    bell: Waker,
    closed: AtomicBool,
}

impl Scribe {
    /// Keeps at most `limit` bytes of each of an attempt's two outputs.
    ///
    /// # Errors
    /// When the host has no descriptor or no thread left.
    pub(super) fn new(limit: usize) -> io::Result<Self> {
        let desk = Arc::new(Desk {
            epoll: epoll::create(epoll::CreateFlags::CLOEXEC)?,
            pipes: Mutex::default(),
            bell: Waker::new()?,
            closed: AtomicBool::new(false),
        });
        let data = epoll::EventData::new_u64(BELL);
        epoll::add(&desk.epoll, &desk.bell, data, epoll::EventFlags::IN)?;
        let own = Arc::clone(&desk);
        let thread = std::thread::Builder::new().name("task-output".into());
        let thread = Some(thread.spawn(move || own.serve())?);
        Ok(Self { desk, limit, next: 0, thread })
    }

    /// Reads these two, standard output first.
    ///
    /// # Errors
    /// The kernel's.
    pub(super) fn capture(&mut self, stdout: OwnedFd, stderr: OwnedFd) -> io::Result<Capture> {
        let pipes = [self.read(stdout)?, self.read(stderr)?];
        Ok(Capture { desk: Arc::clone(&self.desk), pipes })
    }

    fn read(&mut self, source: OwnedFd) -> io::Result<(u64, Arc<Mutex<Pipe>>)> {
        fcntl_setfl(&source, OFlags::NONBLOCK)?;
        let token = self.next;
        self.next += 1;
        let data = epoll::EventData::new_u64(token);
        // What is readable before the thread finds it stays so.
        epoll::add(&self.desk.epoll, &source, data, epoll::EventFlags::IN)?;
        let pipe = Arc::new(Mutex::new(Pipe::new(source, self.limit)));
        self.desk.pipes.lock().insert(token, Arc::clone(&pipe));
        Ok((token, pipe))
    }
}

impl Drop for Scribe {
    fn drop(&mut self) {
        // Release, with the Acquire of the thread's load: the bell alone would
        // do, and this does not lean on it.
        self.desk.closed.store(true, Ordering::Release);
        self.desk.bell.wake();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Desk {
    fn serve(&self) {
        let mut ready = Vec::with_capacity(16);
        while !self.closed.load(Ordering::Acquire) {
            ready.clear();
            match epoll::wait(&self.epoll, spare_capacity(&mut ready), None) {
                Ok(_) | Err(Errno::INTR) => {}
                Err(_) => return,
            }
            for event in &ready {
                match event.data.u64() {
                    BELL => drop(self.bell.take()),
                    token => self.attend(token),
                }
            }
        }
    }

    fn attend(&self, token: u64) {
        let Some(pipe) = self.pipes.lock().get(&token).cloned() else { return };
        let mut held = pipe.lock();
        held.read(TURN);
        if held.ended {
            self.close(token, &mut held);
        }
    }

    fn close(&self, token: u64, pipe: &mut Pipe) {
        if let Some(source) = pipe.source.take() {
            // Not left to the closing: a child between fork and exec has a copy
            // of the descriptor, and the kernel would go on to report it.
            let _ = epoll::delete(&self.epoll, &source);
        }
        self.pipes.lock().remove(&token);
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn what_a_larger_pipe_holds_at_the_end_is_not_left_in_it() {
        let (source, mut print) = std::io::pipe().unwrap();
        let larger = rustix::pipe::fcntl_setpipe_size(&source, 4 * TURN).unwrap();
        assert!(larger >= 4 * TURN);
        fcntl_setfl(&source, OFlags::NONBLOCK).unwrap();
        print.write_all(&vec![b'x'; 3 * TURN]).unwrap();
        print.write_all(b"the end").unwrap();
        let mut pipe = Pipe::new(source.into(), 7);
        pipe.drain();
        assert_eq!(pipe.printed().tail, b"the end");
    }

    #[test]
    fn the_end_is_kept_and_the_rest_is_counted() {
        let mut scribe = Scribe::new(10).unwrap();
        let (stdout, mut out) = std::io::pipe().unwrap();
        let (stderr, mut err) = std::io::pipe().unwrap();
        let capture = scribe.capture(stdout.into(), stderr.into()).unwrap();
        err.write_all(b"short").unwrap();
        let written = 300_000_u64;
        let mut left = written;
        while left > 0 {
            out.write_all(format!("{left:010}").as_bytes()).unwrap();
            left -= 10;
        }
        drop((out, err));
        let output = capture.finish();
        assert_eq!(output.stdout.tail, b"0000000010");
        assert_eq!(output.stdout.dropped, written - 10);
        assert_eq!(output.stderr, Printed { tail: b"short".into(), dropped: 0 });
    }
}
