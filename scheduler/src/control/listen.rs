//! A socket with a name, that its owner alone can open.

use std::ffi::OsString;
use std::fs::{DirBuilder, File, Metadata, OpenOptions, Permissions};
use std::io::{self, ErrorKind};
use std::os::unix::fs::{DirBuilderExt, FileTypeExt, MetadataExt, OpenOptionsExt, PermissionsExt};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};

use rustix::fs::{CWD, FlockOperation, OFlags, RenameFlags, flock, renameat_with};

/// Nobody else reads, writes or connects.
const OWNER_ONLY: u32 = 0o600;

/// A listening socket, and the lock that keeps other managers from its name.
/// Both go when this goes.
#[derive(Debug)]
pub(super) struct Listening {
    pub(super) listener: UnixListener,
    path: PathBuf,
    lock: PathBuf,
    /// Device and number of the socket's file: what is removed must be ours.
    ours: (u64, u64),
    _locked: File,
}

impl Listening {
    /// Listens at this path.
    ///
    /// # Errors
    /// [`ErrorKind::AddrInUse`] if somebody listens there,
    /// [`ErrorKind::AlreadyExists`] if there is a file that is no socket.
    pub(super) fn at(path: &Path) -> io::Result<Self> {
        let mut lock = OsString::from(path);
        lock.push(".lock");
        let lock = PathBuf::from(lock);
        let locked = lock_at(&lock, path)?;
        let is_stale = is_stale(path)?;
        let (listener, ours) = named(path, is_stale)?;
        listener.set_nonblocking(true)?;
        Ok(Self { listener, path: path.into(), lock, ours, _locked: locked })
    }
}

impl Drop for Listening {
    fn drop(&mut self) {
        // What cannot be removed is replaced by the next one who listens here.
        if std::fs::symlink_metadata(&self.path).is_ok_and(|found| identity(&found) == self.ours) {
            let _ = std::fs::remove_file(&self.path);
        }
        let _ = std::fs::remove_file(&self.lock);
    }
}

fn identity(file: &Metadata) -> (u64, u64) {
    (file.dev(), file.ino())
}

fn in_use(path: &Path) -> io::Error {
    let why = format!("a schedule manager listens at {} already", path.display());
    io::Error::new(ErrorKind::AddrInUse, why)
}

/// The lock of a path. The one who holds it takes its file away at the end, so
/// the file that was locked must still be the one that has the name.
fn lock_at(lock: &Path, path: &Path) -> io::Result<File> {
    loop {
        let no_follow = i32::try_from(OFlags::NOFOLLOW.bits()).unwrap_or_default();
        let mut options = OpenOptions::new();
        options.write(true).create(true).mode(OWNER_ONLY).custom_flags(no_follow);
        let file = options.open(lock).map_err(|error| {
            io::Error::new(error.kind(), format!("{}: {error}", lock.display()))
        })?;
        match flock(&file, FlockOperation::NonBlockingLockExclusive) {
            Ok(()) => {}
            Err(rustix::io::Errno::WOULDBLOCK) => return Err(in_use(path)),
            Err(error) => return Err(error.into()),
        }
        let named = std::fs::symlink_metadata(lock);
        if named.is_ok_and(|named| file.metadata().is_ok_and(|m| identity(&m) == identity(&named)))
        {
            return Ok(file);
        }
    }
}

/// Whether a socket is left there that nobody listens at.
fn is_stale(path: &Path) -> io::Result<bool> {
    match std::fs::symlink_metadata(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(false),
        Err(error) => return Err(error),
        Ok(found) if !found.file_type().is_socket() => {
            let why = format!("{} is there, and is no socket: it is left as it is", path.display());
            return Err(io::Error::new(ErrorKind::AlreadyExists, why));
        }
        Ok(_) => {}
    }
    match UnixStream::connect(path) {
        Err(error) if error.kind() == ErrorKind::ConnectionRefused => Ok(true),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(false),
        Err(error) if error.kind() != ErrorKind::WouldBlock => Err(error),
        _ => Err(in_use(path)),
    }
}

/// Makes the socket where nobody else can see it, and gives it its name when it
/// is as it should be.
fn named(path: &Path, replaces: bool) -> io::Result<(UnixListener, (u64, u64))> {
    let private = Private::beside(path)?;
    let hidden = private.0.join("s");
    let listener = UnixListener::bind(&hidden)?;
    std::fs::set_permissions(&hidden, Permissions::from_mode(OWNER_ONLY))?;
    let ours = identity(&std::fs::symlink_metadata(&hidden)?);
    let flags = if replaces { RenameFlags::empty() } else { RenameFlags::NOREPLACE };
    if let Err(error) = renameat_with(CWD, &hidden, CWD, path, flags) {
        let _ = std::fs::remove_file(&hidden);
        return Err(error.into());
    }
    Ok((listener, ours))
}

/// A directory that its owner alone can enter, as long as this lives.
struct Private(PathBuf);

impl Private {
    fn beside(path: &Path) -> io::Result<Self> {
        let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
        let parent = parent.unwrap_or(Path::new("."));
        let process = std::process::id();
        for number in 0..100 {
            // Short: the names of sockets have a limit.
            let name = parent.join(format!(".f{process}.{number}"));
            match DirBuilder::new().mode(0o700).create(&name) {
                Ok(()) => return Ok(Self(name)),
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                Err(error) => {
                    let why = format!("no socket can be made in {}: {error}", parent.display());
                    return Err(io::Error::new(error.kind(), why));
                }
            }
        }
        let why = format!("{} is full of what earlier managers left", parent.display());
        Err(io::Error::new(ErrorKind::AlreadyExists, why))
    }
}

impl Drop for Private {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir(&self.0);
    }
}
