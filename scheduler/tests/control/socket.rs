//! The socket's file: who can open it, and whose it is.

use std::fs::Permissions;
use std::io::ErrorKind;
use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use faregate_client::{Control, Error};
use faregate_scheduler::control::SocketLink;
use faregate_scheduler::executive::Waker;

use crate::control::stage::read;

fn listen(path: &Path) -> std::io::Result<SocketLink> {
    SocketLink::listen(path, Arc::new(read), Waker::new().unwrap())
}

fn directory() -> (tempfile::TempDir, std::path::PathBuf) {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("faregate.sock");
    (directory, path)
}

fn mode(path: &Path) -> u32 {
    std::fs::symlink_metadata(path).unwrap().permissions().mode() & 0o777
}

#[test]
fn nobody_else_can_open_the_socket_from_its_first_instant_on() {
    let (_directory, path) = directory();
    let over = Arc::new(AtomicBool::new(false));
    let looks = {
        let (path, over) = (path.clone(), Arc::clone(&over));
        std::thread::spawn(move || {
            let mut seen = 0_u32;
            while !over.load(Ordering::Acquire) {
                if let Ok(found) = std::fs::symlink_metadata(&path) {
                    assert!(found.file_type().is_socket());
                    assert_eq!(found.permissions().mode() & 0o777, 0o600);
                    seen += 1;
                }
            }
            seen
        })
    };
    for _ in 0..200 {
        let link = listen(&path).unwrap();
        assert_eq!((mode(&path), mode(&path.with_extension("sock.lock"))), (0o600, 0o600));
        drop(link);
    }
    over.store(true, Ordering::Release);
    assert!(looks.join().unwrap() > 0);
}

#[test]
fn a_manager_leaves_no_file_behind() {
    let (directory, path) = directory();
    let link = listen(&path).unwrap();
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 2);
    drop(link);
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 0);
    assert!(matches!(Control::connect(&path), Err(Error::NoPort(_))));
}

#[test]
fn of_two_managers_on_one_path_the_second_is_refused_and_the_first_undisturbed() {
    let (_directory, path) = directory();
    let first = listen(&path).unwrap();
    let error = listen(&path).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::AddrInUse);
    Control::connect(&path).unwrap();
    drop(first);
    listen(&path).unwrap();
}

#[test]
fn of_managers_that_start_at_the_same_time_one_listens() {
    let (_directory, path) = directory();
    for _ in 0..20 {
        let start = Arc::new(std::sync::Barrier::new(4));
        let managers: Vec<_> = (0..4)
            .map(|_| (path.clone(), Arc::clone(&start)))
            .map(|(path, start)| {
                std::thread::spawn(move || {
                    start.wait();
                    listen(&path)
                })
            })
            .collect();
        let listening: Vec<_> =
            managers.into_iter().filter_map(|manager| manager.join().unwrap().ok()).collect();
        assert_eq!(listening.len(), 1);
        Control::connect(&path).unwrap();
    }
}

#[test]
fn the_lock_beside_the_socket_decides() {
    let (_directory, path) = directory();
    drop(UnixListener::bind(&path).unwrap());
    // As a manager that is about to replace it holds it.
    let lock = std::fs::File::create(path.with_extension("sock.lock")).unwrap();
    rustix::fs::flock(&lock, rustix::fs::FlockOperation::LockExclusive).unwrap();
    assert_eq!(listen(&path).unwrap_err().kind(), ErrorKind::AddrInUse);
    drop(lock);
    listen(&path).unwrap();
}

#[test]
fn a_socket_that_nobody_listens_at_is_replaced() {
    let (_directory, path) = directory();
    drop(UnixListener::bind(&path).unwrap());
    let stale = std::fs::symlink_metadata(&path).unwrap().ino();
    assert!(matches!(Control::connect(&path), Err(Error::NoPort(_))));
    let link = listen(&path).unwrap();
    assert_ne!(std::fs::symlink_metadata(&path).unwrap().ino(), stale);
    assert_eq!(mode(&path), 0o600);
    Control::connect(&path).unwrap();
    drop(link);
}

#[test]
fn what_is_somebody_elses_is_left_as_it_is() {
    let (_directory, path) = directory();
    std::fs::write(&path, "a log").unwrap();
    assert_eq!(listen(&path).unwrap_err().kind(), ErrorKind::AlreadyExists);
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "a log");

    std::fs::remove_file(&path).unwrap();
    let other = UnixListener::bind(&path).unwrap();
    assert_eq!(listen(&path).unwrap_err().kind(), ErrorKind::AddrInUse);
    UnixStream::connect(&path).unwrap();
    other.accept().unwrap();
    drop(other);

    // A manager whose socket was replaced does not take the other one away.
    let link = listen(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    std::fs::write(&path, "a log").unwrap();
    drop(link);
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "a log");
}

#[test]
fn where_no_socket_can_be_made_the_error_says_where() {
    let (directory, _) = directory();
    let nowhere = directory.path().join("no-such-directory/faregate.sock");
    let error = listen(&nowhere).unwrap_err().to_string();
    assert!(error.contains("no-such-directory"), "{error}");
}

#[test]
fn another_user_is_refused_even_where_the_permissions_were_opened() {
    const NOBODY: u32 = 65534;
    if !rustix::process::geteuid().is_root() {
        assert!(std::env::var_os("CI").is_none(), "needs root, to become another user");
        eprintln!("skipped: needs root, to become another user");
        return;
    }
    let (directory, path) = directory();
    let _link = listen(&path).unwrap();
    std::fs::set_permissions(directory.path(), Permissions::from_mode(0o755)).unwrap();
    assert_eq!(knock(&path, NOBODY), "not connected");
    std::fs::set_permissions(&path, Permissions::from_mode(0o666)).unwrap();
    assert!(knock(&path, NOBODY).contains("not_permitted"));
    assert!(knock(&path, 0).contains("hello"));
}

/// What another user's process hears there.
fn knock(path: &Path, user: u32) -> String {
    use std::os::unix::process::CommandExt;
    // Beside the socket, where another user can run it.
    let program = path.with_file_name("knocks");
    if !program.exists() {
        std::fs::copy(std::env::current_exe().unwrap(), &program).unwrap();
    }
    let mut command = std::process::Command::new(program);
    command.args(["--exact", "control::socket::a_part_of_the_test_above", "--nocapture"]);
    command.env("FAREGATE_TEST_KNOCKS", path).uid(user).current_dir("/");
    let output = command.output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let (_, heard) = text.split_once('<').unwrap_or_else(|| panic!("{text} {:?}", output.stderr));
    heard.split_once('>').unwrap().0.into()
}

#[test]
fn a_part_of_the_test_above() {
    let Some(path) = std::env::var_os("FAREGATE_TEST_KNOCKS") else { return };
    let Ok(stream) = UnixStream::connect(path) else { return println!("<not connected>") };
    let mut line = String::new();
    std::io::BufRead::read_line(&mut std::io::BufReader::new(stream), &mut line).unwrap();
    println!("<{line}>");
}
