//! A party's endpoints and the hub between them and its session.

use std::net::SocketAddr;
use std::task::Poll;
use std::time::Duration;

use mavlink::MessageData as _;
use mavlink::dialects::common::HEARTBEAT_DATA;

use super::super::autopilot::AUTOPILOT_COMPONENT;
use super::super::faults::Faults;
use super::super::frame::{Frame, message_id};
use super::super::hub::{EndpointId, Hub, HubConfig, HubEvent};
use super::super::parachute::PARACHUTE_COMPONENT;
use super::super::session::{Link, Transmit};
use super::clock::UnixClock;
use super::endpoint::{Arrival, Endpoint, LINE_END};
use super::notice::{GarbageWatch, LineNotice, Notice, Observer, ShellError, What};
use super::ports::{Ports, loopback};
use super::serial::{LineNews, SerialLine, SerialUrl};
use super::stamp_store::{Keeper, SignWith};
use super::url::LinkUrl;

/// A peer that is silent is served for this long.
pub(super) const PEER_MEMORY: Duration = Duration::from_secs(10);

/// What is wired besides an instance's own ports.
#[derive(Clone, Debug, Default)]
pub struct Wiring {
    /// Further endpoints for ground stations.
    pub urls: Vec<LinkUrl>,
    /// How everything but the simulator's link is signed.
    pub sign: Option<SignWith>,
}

/// One endpoint with its name and the faults reported of it.
#[derive(Debug)]
struct Named {
    endpoint: Endpoint,
    link: Link,
    what: What,
    garbage: GarbageWatch,
}

/// All of a party's endpoints.
#[derive(Debug)]
pub(super) struct Links {
    hub: Hub<SocketAddr>,
    endpoints: Vec<Named>,
    clock: UnixClock,
    /// With a key.
    stamps: Option<Keeper>,
    /// There is a component of the vehicle behind the party.
    routes: bool,
    /// The serial line is there.
    line_is_up: bool,
}

impl Links {
    /// For a party of system and component `own`, without endpoints yet; silent peers are served for
    /// `memory`.
    ///
    /// # Errors
    /// [`ShellError`] when the time stamps of signed frames cannot be kept, or the clock is far behind them.
    pub(super) fn new(
        own: (u8, u8),
        memory: Duration,
        forwards: bool,
        sign: Option<&SignWith>,
    ) -> Result<Self, ShellError> {
        let memory_us = u64::try_from(memory.as_micros()).unwrap_or(u64::MAX);
        let mut hub = Hub::new(HubConfig { own, memory_us, forwards, key: sign.map(|s| s.key) });
        let clock = UnixClock::start();
        let mut stamps = None;
        if let Some(sign) = sign {
            let (keeper, earlier) = Keeper::open(sign, own)?;
            hub.resume(clock.now_us(), earlier).map_err(|error| keeper.refuse(error))?;
            stamps = Some(keeper);
        }
        Ok(Self { hub, endpoints: Vec::new(), clock, stamps, routes: false, line_is_up: false })
    }

    /// The links of an autopilot: to ground stations, to companions, to the parachute, and those that are
    /// wired besides. Purposes begin with `prefix`.
    pub(super) async fn of_autopilot(
        system_id: u8,
        ports: &Ports,
        wiring: &Wiring,
        prefix: &str,
        observer: &mut impl Observer,
    ) -> Result<Self, ShellError> {
        let mut links = Self::new((system_id, AUTOPILOT_COMPONENT), PEER_MEMORY, true, wiring.sign.as_ref())?;
        let (at, what) = (ports.autopilot_ground, format!("{prefix}for ground stations"));
        links.bind_udp(Link::GroundStation, at, what, &[ports.ground_station], observer).await?;
        let (at, what) = (ports.autopilot_api, format!("{prefix}for companions"));
        links.bind_udp(Link::Api, at, what, &[ports.api], observer).await?;
        links.route_to_parachute(ports, observer).await?;
        for url in &wiring.urls {
            links.open(url, observer).await?;
        }
        Ok(links)
    }

    /// The links of a parachute that a simulator hosts for a board on a serial line, in whose place it stands
    /// for all others: the ports of the board's autopilot are opened here, and what comes by them goes on
    /// over the line, and the other way round.
    pub(super) async fn of_board(
        system_id: u8,
        ports: &Ports,
        url: &SerialUrl,
        observer: &mut impl Observer,
    ) -> Result<Self, ShellError> {
        let mut links = Self::new((system_id, PARACHUTE_COMPONENT), PEER_MEMORY, true, None)?;
        let line = Endpoint::Serial(Box::new(SerialLine::open(url)?));
        let id = links.add(line, Link::Simulator, What::from(url.to_string()));
        links.hub.stand_for(id);
        let (at, to) = (ports.autopilot_ground, [ports.ground_station]);
        links.bind_udp(Link::GroundStation, at, "board, for ground stations", &to, observer).await?;
        let (at, to) = (ports.autopilot_api, [ports.api]);
        links.bind_udp(Link::Api, at, "board, for companions", &to, observer).await?;
        Ok(links)
    }

    /// Binds a loopback UDP port; `defaults` are the loopback ports that are sent to unasked.
    pub(super) async fn bind_udp(
        &mut self,
        link: Link,
        port: u16,
        what: impl Into<What>,
        defaults: &[u16],
        observer: &mut impl Observer,
    ) -> Result<(), ShellError> {
        let what = what.into();
        let endpoint = Endpoint::udp(loopback(port), None, &what, observer).await?;
        let id = self.add(endpoint, link, what);
        for remote in defaults {
            self.hub.keep(self.clock.now_us(), id, loopback(*remote));
        }
        Ok(())
    }

    /// Opens what was typed.
    pub(super) async fn open(
        &mut self,
        url: &LinkUrl,
        observer: &mut impl Observer,
    ) -> Result<(), ShellError> {
        let what = What::from(url.to_string());
        let endpoint = Endpoint::open(url, &what, observer).await?;
        self.add(endpoint, url.link, what);
        Ok(())
    }

    /// Opens the way to the parachute, so that who meets the autopilot meets the parachute too, as through a
    /// MAVLink router. The simulator behind it hears of companions, and can keep step with their setpoints.
    pub(super) async fn route_to_parachute(
        &mut self,
        ports: &Ports,
        observer: &mut impl Observer,
    ) -> Result<(), ShellError> {
        let what = What::from("autopilot, for the parachute");
        let endpoint = Endpoint::udp_towards(loopback(ports.parachute), &what, observer).await?;
        let id = self.add(endpoint, Link::Parachute, what);
        self.hub.show_companions_to(id);
        self.routes = true;
        Ok(())
    }

    /// The autopilot of a system may bring, as a router, what comes straight as well; it has a place of its
    /// own.
    pub(super) fn expect_router(&mut self, system_id: u8) {
        self.hub.expect_doubles();
        self.hub.reserve_for((system_id, AUTOPILOT_COMPONENT));
    }

    /// Whether default remotes that have not spoken hear what is for everybody.
    pub(super) fn speak_unasked(&mut self, speaks: bool) {
        self.hub.speak_unasked(speaks);
    }

    /// Whether the serial line is there, for links that have one.
    pub(super) fn line_is_up(&self) -> bool {
        self.line_is_up
    }

    /// The name of the serial line, for links that have one.
    pub(super) fn line_name(&self) -> &str {
        let line = self.endpoints.iter().find(|named| matches!(named.endpoint, Endpoint::Serial(_)));
        line.map_or("", |named| &named.what)
    }

    fn add(&mut self, endpoint: Endpoint, link: Link, what: What) -> EndpointId {
        let id = self.hub.add_endpoint(link);
        if let Some(remote) = endpoint.default_remote() {
            self.hub.keep(self.clock.now_us(), id, remote);
        }
        self.endpoints.push(Named { endpoint, link, what, garbage: GarbageWatch::default() });
        id
    }

    /// Waits until there may be something to be received. Safe to cancel.
    pub(super) async fn readable(&mut self) {
        std::future::poll_fn(|cx| {
            let mut ready = false;
            for named in &mut self.endpoints {
                ready |= named.endpoint.poll_readable(cx).is_ready();
            }
            if ready { Poll::Ready(()) } else { Poll::Pending }
        })
        .await;
    }

    /// Takes what has come, without waiting, and passes on what is for others. Whether nothing more is there.
    pub(super) fn receive<O: Observer>(
        &mut self,
        observer: &mut O,
        mut each: impl FnMut(&mut O, Link, &Frame),
    ) -> bool {
        let Self { hub, endpoints, clock, line_is_up, .. } = self;
        let now = clock.now_us();
        let mut is_empty = true;
        for (i, named) in endpoints.iter_mut().enumerate() {
            let id = EndpointId(i as u8);
            let (link, what) = (named.link, &named.what);
            let mut any_frame = false;
            is_empty &= named.endpoint.receive(&mut |arrival| match arrival {
                Arrival::Datagram(from, bytes) => {
                    hub.datagram(now, id, from, bytes, |frame| each(observer, link, frame));
                    true
                }
                Arrival::Stream(from, bytes) => {
                    hub.stream(now, id, from, bytes, |frame| each(observer, link, frame));
                    true
                }
                Arrival::Accepted(peer) => {
                    hub.accept(now, id, peer);
                    observer.notice(Notice::Connected(peer, what.clone()));
                    true
                }
                Arrival::Connected(peer) => {
                    let (room, what) = (hub.keep(now, id, peer), what.clone());
                    let connected = if room { Notice::Connected } else { Notice::Crowded };
                    observer.notice(connected(peer, what));
                    room
                }
                Arrival::Ended(peer, reason) => {
                    hub.forget(id, peer);
                    observer.notice(Notice::Disconnected(peer, reason));
                    true
                }
                Arrival::NobodyThere(at) => {
                    observer.notice(Notice::NobodyThere(at, what.clone()));
                    true
                }
                Arrival::Line(LineNews::Bytes(bytes)) => {
                    hub.stream(now, id, LINE_END, bytes, |frame| {
                        any_frame = true;
                        each(observer, link, frame);
                    });
                    true
                }
                Arrival::Line(news) => {
                    let notice = match news {
                        LineNews::Lost(why) => LineNotice::Lost(why),
                        LineNews::Stalled(frames) => LineNotice::Stalled(frames),
                        LineNews::Open | LineNews::Bytes(_) => LineNotice::Open,
                    };
                    match &notice {
                        LineNotice::Open => {
                            hub.forget(id, LINE_END);
                            *line_is_up = hub.keep(now, id, LINE_END);
                        }
                        LineNotice::Lost(_) => *line_is_up = false,
                        _ => {}
                    }
                    observer.notice(Notice::Line(what.to_string(), notice));
                    true
                }
            });
            if let Endpoint::Serial(line) = &mut named.endpoint {
                let skipped = hub.faults(id).skipped_bytes;
                if any_frame {
                    line.note_frame();
                } else if line.is_garbled_now(skipped) {
                    observer.notice(Notice::Line(what.to_string(), LineNotice::Garbled(skipped)));
                }
            }
            named.garbage.look(what, &hub.faults(id), observer);
        }
        while let Some((id, peer)) = self.hub.poll_close(now) {
            let reason = "it has said nothing that is let in";
            self.endpoints[usize::from(id.0)].endpoint.close(peer, reason);
        }
        self.report_and_pass_on(observer);
        is_empty
    }

    fn report_and_pass_on(&mut self, observer: &mut impl Observer) {
        if let (Some(keeper), Some(stamps)) = (&mut self.stamps, self.hub.poll_stamps()) {
            keeper.store(&stamps, observer);
        }
        while let Some(event) = self.hub.poll_event() {
            let what = |id: EndpointId| self.endpoints[usize::from(id.0)].what.clone();
            observer.notice(match event {
                HubEvent::Heard(id, LINE_END) => Notice::Line(what(id).to_string(), LineNotice::Heard),
                HubEvent::Heard(id, peer) => Notice::Heard(peer, what(id)),
                HubEvent::Crowded(id, peer) => Notice::Crowded(peer, what(id)),
                HubEvent::OtherClock(id, peer, sender, ahead_s) => {
                    Notice::OtherClock(peer, what(id), sender, ahead_s)
                }
            });
        }
        while let Some((id, to, bytes)) = self.hub.poll_forward() {
            self.endpoints[usize::from(id.0)].endpoint.queue(to, &bytes);
        }
        self.flush();
    }

    /// Sends one of the party's frames to those it is for.
    pub(super) fn send(&mut self, transmit: &Transmit) {
        self.queue(transmit);
        self.flush();
    }

    /// Sends what was queued: what one peer gets of it shares datagrams.
    pub(super) fn flush(&mut self) {
        self.endpoints.iter_mut().for_each(|named| named.endpoint.flush());
    }

    /// Takes one of the party's frames for those it is for, to be sent by [`Self::flush`].
    pub(super) fn queue(&mut self, transmit: &Transmit) {
        let Self { hub, endpoints, clock, .. } = self;
        let now = clock.now_us();
        let mut out = |id: EndpointId, to, bytes: &[u8]| {
            endpoints[usize::from(id.0)].endpoint.queue(to, bytes);
        };
        hub.send(now, transmit, &mut out);
        // By this the parachute knows its router.
        if self.routes
            && transmit.link == Link::Api
            && message_id(&transmit.bytes) == Some(HEARTBEAT_DATA::ID)
        {
            let beat = Transmit::to_all(Link::Parachute, transmit.bytes.clone());
            hub.send(now, &beat, &mut out);
        }
    }

    /// What has come by all endpoints, by kind.
    pub(super) fn faults(&self) -> Faults {
        let mut sum = Faults::default();
        (0..self.endpoints.len()).for_each(|i| sum.add(&self.hub.faults(EndpointId(i as u8))));
        sum
    }

    /// At the end: keeps the time stamps, and tells what came by each endpoint, if anything was wrong there.
    pub(super) fn finish(&mut self, observer: &mut impl Observer) {
        if let (Some(keeper), Some(stamps)) = (&mut self.stamps, self.hub.stamps()) {
            keeper.store(stamps, observer);
        }
        for (i, named) in self.endpoints.iter().enumerate() {
            let faults = self.hub.faults(EndpointId(i as u8));
            observer.notice(Notice::Counts(named.what.clone(), faults));
        }
    }
}
