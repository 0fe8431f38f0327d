//! Who comes in.

use std::io;
use std::os::unix::net::UnixStream;
use std::sync::atomic::Ordering::Relaxed;

use faregate_client::wire::control::{Answer, Said};
use faregate_client::{PROTOCOL, RefusalKind, Refused};
use rustix::event::epoll::{self, EventData, EventFlags};
use rustix::io::Errno;

use crate::control::MAX_CLIENTS;
use crate::control::client::Client;
use crate::control::thread::{LISTENER, Server};

impl Server {
    pub(super) fn listen(&self, flags: EventFlags) {
        let data = EventData::new_u64(LISTENER);
        let _ = epoll::modify(&self.epoll, &self.listening.listener, data, flags);
    }

    pub(super) fn let_in(&mut self) {
        match self.listening.listener.accept() {
            Ok((stream, _)) => self.greet(stream),
            Err(error) if is_short(&error) => {
                // Whoever waits stays in the queue, and would wake us again at
                // once.
                self.is_short = true;
                self.listen(EventFlags::empty());
            }
            // Who knocked has gone again.
            Err(_) => {}
        }
    }

    fn greet(&mut self, stream: UnixStream) {
        let welcome = may_come_in(&stream).and_then(|()| self.has_room());
        if stream.set_nonblocking(true).is_err() {
            return;
        }
        let mut client = Client::new(stream);
        match welcome {
            Err(why) => {
                self.tools.shared.turned_away.fetch_add(1, Relaxed);
                client.answer(None, Answer::Refused(why));
                let _ = client.send();
            }
            Ok(()) => {
                self.tools.shared.clients.fetch_add(1, Relaxed);
                let program = concat!("faregate ", env!("CARGO_PKG_VERSION")).into();
                client.say(&Said::Hello { protocol: PROTOCOL, program });
                self.admit(client);
            }
        }
    }

    fn has_room(&self) -> Result<(), Refused> {
        if self.clients.len() < MAX_CLIENTS {
            return Ok(());
        }
        let why = format!("the manager serves {MAX_CLIENTS} clients already");
        Err(Refused::new(RefusalKind::Busy, why))
    }
}

fn is_short(error: &io::Error) -> bool {
    let short = [Errno::MFILE, Errno::NFILE, Errno::NOBUFS, Errno::NOMEM];
    Errno::from_io_error(error).is_some_and(|error| short.contains(&error))
}

/// The manager's own user, and root. The socket's permissions say the same;
/// they can be changed by mistake.
fn may_come_in(stream: &UnixStream) -> Result<(), Refused> {
    let ours = rustix::process::geteuid();
    let theirs = rustix::net::sockopt::socket_peercred(stream).map(|peer| peer.uid);
    if theirs.is_ok_and(|theirs| theirs == ours || theirs.is_root()) {
        return Ok(());
    }
    let why = "the manager takes telecommands of its own user and of root";
    Err(Refused::new(RefusalKind::NotPermitted, why))
}
