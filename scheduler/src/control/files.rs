//! Schedule files that a task loads, read by a thread of their own: a disk can
//! be slow, and the manager's thread waits for none.

use std::fs::File;
use std::io::Read as _;
use std::sync::Arc;

use crossbeam::channel::{Receiver, Sender, unbounded};
use rustix::fs::{Mode, OFlags, open};

use crate::control::{MAX_FILE, MISTAKES_OF_FILE, ReadSchedule, reading};
use crate::executive::{LoadedFile, Waker};
use crate::manager::Attempt;

type Ask = (Attempt, String);
type Answer = (Attempt, LoadedFile);

/// Has files read, one after the other: those that are due at one instant come
/// into the schedule in their order.
pub(super) struct Files {
    schedules: Arc<dyn ReadSchedule>,
    manager: Waker,
    /// There from the first file on: most schedules load none.
    reader: Option<Reader>,
}

struct Reader {
    asks: Sender<Ask>,
    answers: Receiver<Answer>,
}

impl Files {
    pub(super) fn new(schedules: Arc<dyn ReadSchedule>, manager: Waker) -> Self {
        Self { schedules, manager, reader: None }
    }

    /// Has this file read. The manager's bell is rung when it was.
    ///
    /// # Errors
    /// When the host gives no thread.
    pub(super) fn ask(&mut self, attempt: Attempt, path: &str) -> Result<(), String> {
        let reader = match &mut self.reader {
            Some(reader) => reader,
            none => none.insert(Reader::start(&self.schedules, &self.manager)?),
        };
        let asked = reader.asks.send((attempt, path.to_owned()));
        asked.map_err(|_| format!("{path}: nobody reads files any more"))
    }

    /// A file that was read since, or why it was not.
    pub(super) fn answer(&self) -> Option<Answer> {
        self.reader.as_ref()?.answers.try_recv().ok()
    }
}

impl Reader {
    /// The thread ends when it is at the end of a file and nobody asks for
    /// another one. It is not waited for: the disk may never answer.
    fn start(schedules: &Arc<dyn ReadSchedule>, manager: &Waker) -> Result<Self, String> {
        let (asks, asked) = unbounded::<Ask>();
        let (read, answers) = unbounded();
        let (schedules, manager) = (Arc::clone(schedules), manager.clone());
        let work = move || {
            for (attempt, path) in asked {
                if read.send((attempt, load(&*schedules, &path))).is_err() {
                    return;
                }
                manager.wake();
            }
        };
        let thread = std::thread::Builder::new().name("faregate-files".into());
        thread.spawn(work).map_err(|error| format!("no thread for reading files: {error}"))?;
        Ok(Self { asks, answers })
    }
}

fn load(schedules: &dyn ReadSchedule, path: &str) -> LoadedFile {
    let text = schedule_text(path).map_err(|why| format!("{path}: {why}"))?;
    let read = reading::read(schedules, path, &text, MISTAKES_OF_FILE);
    read.map_err(|refused| format!("{path}: {refused}"))
}

/// The text of a schedule file that a task loads: a regular one, of at most
/// [`MAX_FILE`] bytes.
///
/// # Errors
/// Why it is not read, for people.
pub fn schedule_text(path: &str) -> Result<String, String> {
    // Opening what is no file must not wait either: a pipe would, for a writer.
    let flags = OFlags::RDONLY | OFlags::CLOEXEC | OFlags::NONBLOCK | OFlags::NOCTTY;
    let file = open(path, flags, Mode::empty()).map_err(|error| error.to_string())?;
    let file = File::from(file);
    if !file.metadata().map_err(|error| error.to_string())?.is_file() {
        return Err("not a regular file".to_owned());
    }
    let mut text = String::new();
    // It may grow while it is read.
    let read = file.take(MAX_FILE + 1).read_to_string(&mut text);
    let read = read.map_err(|error| error.to_string())?;
    if u64::try_from(read).is_ok_and(|read| read <= MAX_FILE) {
        Ok(text)
    } else {
        Err(format!("longer than the {} MiB that a task may load", MAX_FILE >> 20))
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_regular_file_is_read() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("more.txt");
        fs::write(&path, "1 0 0\n").unwrap();
        assert_eq!(schedule_text(path.to_str().unwrap()), Ok("1 0 0\n".to_owned()));
    }

    #[test]
    fn what_is_no_file_is_refused_and_nobody_waits_for_it() {
        let directory = tempfile::tempdir().unwrap();
        let pipe = directory.path().join("pipe");
        let mode = rustix::fs::Mode::RUSR;
        let kind = rustix::fs::FileType::Fifo;
        rustix::fs::mknodat(rustix::fs::CWD, &pipe, kind, mode, 0).unwrap();
        for path in [pipe.as_path(), directory.path(), "/dev/zero".as_ref()] {
            let refused = schedule_text(path.to_str().unwrap()).unwrap_err();
            assert_eq!(refused, "not a regular file", "{}", path.display());
        }
    }

    #[test]
    fn a_file_that_is_too_long_is_refused() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("long.txt");
        // A hole: it takes no room on the disk.
        File::create(&path).unwrap().set_len(MAX_FILE + 1).unwrap();
        assert!(
            schedule_text(path.to_str().unwrap()).unwrap_err().contains("longer than the 64 MiB")
        );
    }

    #[test]
    fn a_reader_that_panics_fails_and_says_so() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("bad.txt");
        fs::write(&path, "").unwrap();
        let panics = |_: &str, _: &str| panic!("as it is to");
        let failed = load(&panics, path.to_str().unwrap()).unwrap_err();
        assert!(failed.contains("bad.txt: its reader panicked"), "{failed}");
    }
}
