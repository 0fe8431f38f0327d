//! A directory of the host, and who has it.

use std::fs::{DirBuilder, File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::journal::JournalError;
use crate::journal::points::{self, Point};
use crate::journal::storage::{Boot, Storage, StoredFile};

const LOCK: &str = "lock";

/// How long whoever a dead manager was forking may take to die. Far longer than
/// it does.
const CHILDREN_DIE_WITHIN: Duration = Duration::from_secs(5);

/// A directory that nobody else has, for as long as this value lives.
#[derive(Debug)]
pub(super) struct Directory {
    path: PathBuf,
    /// Held by `flock`: it ends with the process, whatever ends that. (It is
    /// closed on exec, so that no task inherits it.)
    _lock: File,
}

impl Directory {
    pub(super) fn open(path: &Path) -> Result<Self, JournalError> {
        let name = path.display().to_string();
        make(path).map_err(JournalError::storage("making", &name))?;
        Ok(Self { path: path.to_owned(), _lock: lock(path)? })
    }
}

/// Only the owner may look: arguments of tasks may be secrets.
fn make(path: &Path) -> io::Result<()> {
    if path.is_dir() {
        return Ok(());
    }
    DirBuilder::new().mode(0o700).create(path)?;
    match path.parent() {
        Some(parent) if parent != Path::new("") => File::open(parent)?.sync_all(),
        _ => File::open(".")?.sync_all(),
    }
}

/// Takes the lock. One whose owner is dead is about to be free: a child that it
/// was just forking has it too, until it is its program or dies.
fn lock(path: &Path) -> Result<File, JournalError> {
    let since = Instant::now();
    loop {
        match try_lock(path) {
            Ok((file, Ok(()))) => return Ok(file),
            Ok((mut file, Err(TryLockError::WouldBlock))) => {
                let by = signature(&mut file);
                if owner_lives(&by) || since.elapsed() > CHILDREN_DIE_WITHIN {
                    return Err(JournalError::InUse { path: path.to_owned(), by });
                }
                wait();
            }
            Ok((_, Err(TryLockError::Error(error)))) | Err(error) => {
                return Err(JournalError::storage("locking", LOCK)(error));
            }
        }
    }
}

fn try_lock(path: &Path) -> io::Result<(File, Result<(), TryLockError>)> {
    let mut options = OpenOptions::new();
    let options = options.read(true).write(true).create(true).truncate(false).mode(0o600);
    let mut file = options.open(path.join(LOCK))?;
    let locked = file.try_lock();
    if locked.is_ok() {
        sign(&mut file)?;
    }
    Ok((file, locked))
}

/// Whether the process that signed is one that can do anything.
fn owner_lives(signature: &str) -> bool {
    let process = signature.split(' ').nth(1).and_then(|number| number.parse::<u32>().ok());
    let Some(process) = process else { return true };
    let Ok(stat) = std::fs::read_to_string(format!("/proc/{process}/stat")) else { return false };
    // The name of the program, in parentheses, comes before its state.
    let state = stat.rsplit_once(") ").map(|(_, rest)| rest.as_bytes().first().copied());
    !matches!(state, Some(Some(b'Z' | b'X')))
}

#[expect(clippy::disallowed_methods, reason = "another process is waited for, in real time")]
fn wait() {
    std::thread::sleep(Duration::from_millis(1));
}

fn sign(file: &mut File) -> io::Result<()> {
    let program = std::env::current_exe().ok();
    let program = program.as_deref().and_then(Path::file_name).unwrap_or("?".as_ref());
    file.set_len(0)?;
    file.seek(SeekFrom::Start(0))?;
    writeln!(file, "process {} ({})", std::process::id(), program.display())
}

/// For people: nothing depends on it.
fn signature(file: &mut File) -> String {
    let mut text = String::new();
    let read = file.take(200).read_to_string(&mut text);
    let text = text.trim();
    if read.is_err() || text.is_empty() { "another process".into() } else { text.into() }
}

impl Storage for Directory {
    fn names(&self) -> io::Result<Vec<String>> {
        let mut names = Vec::new();
        for entry in std::fs::read_dir(&self.path)? {
            // A name that is not UTF-8 is none of ours.
            names.extend(entry?.file_name().into_string());
        }
        Ok(names)
    }

    fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        std::fs::read(self.path.join(name))
    }

    fn create(&self, name: &str) -> io::Result<Box<dyn StoredFile>> {
        let mut options = OpenOptions::new();
        options.write(true).create(true).truncate(true).mode(0o600);
        Ok(Box::new(Appended(options.open(self.path.join(name))?)))
    }

    fn append(&self, name: &str, keep: u64) -> io::Result<Box<dyn StoredFile>> {
        let mut file = Appended(OpenOptions::new().write(true).open(self.path.join(name))?);
        if file.0.metadata()?.len() == keep {
            file.0.seek(SeekFrom::Start(keep))?;
        } else {
            file.cut(keep)?;
        }
        Ok(Box::new(file))
    }

    fn remove(&self, name: &str) -> io::Result<()> {
        points::hit(Point::BeforeRemoval);
        std::fs::remove_file(self.path.join(name))
    }

    fn sync_names(&self) -> io::Result<()> {
        File::open(&self.path)?.sync_all()
    }

    fn boot(&self) -> Boot {
        let text = std::fs::read_to_string("/proc/sys/kernel/random/boot_id");
        let hex = text.unwrap_or_default().trim().replace('-', "");
        match u128::from_str_radix(&hex, 16) {
            Ok(number) if hex.len() == 32 => Boot::new(number.to_be_bytes()),
            _ => Boot::UNKNOWN,
        }
    }
}

/// A file, at its end.
#[derive(Debug)]
struct Appended(File);

impl StoredFile for Appended {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        points::hit(Point::BeforeWrite);
        points::torn(Point::InsideWrite, || {
            // The process is about to die: whether this worked is all the same.
            let _ = self.0.write_all(&bytes[..bytes.len() / 2]);
        });
        self.0.write_all(bytes)?;
        points::hit(Point::AfterWrite);
        Ok(())
    }

    fn cut(&mut self, keep: u64) -> io::Result<()> {
        self.0.set_len(keep)?;
        self.0.seek(SeekFrom::Start(keep)).map(drop)
    }

    /// `fdatasync`: the length counts as data where it is needed to read it.
    fn sync(&mut self) -> io::Result<()> {
        self.0.sync_data()
    }
}
