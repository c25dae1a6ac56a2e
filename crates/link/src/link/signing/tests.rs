//! Against frames that pymavlink signed:
//!
//! ```text
//! mav = MAVLink(None, srcSystem=255, srcComponent=190)  # pymavlink 2.4.50, common, MAVLink 2
//! mav.signing.secret_key = sha256(b"titan").digest()            # the last frame: bytes(range(32))
//! mav.signing.sign_outgoing, mav.signing.link_id, mav.signing.timestamp = True, 3, 36_000_000_000_000
//! mav.seq = 7; mav.heartbeat_encode(6, 8, 0, 0, 4).pack(mav)
//! mav.seq = 8; mav.command_long_encode(1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0).pack(mav)
//! mav.seq = 9; mav.param_request_list_encode(1, 1).pack(mav)
//! ```

use super::super::decoder::Decoder;

use super::super::encoder::Encoder;
use super::*;
use mavlink::dialects::common::{HEARTBEAT_DATA, MavMessage, RADIO_STATUS_DATA};

const HEARTBEAT: &str = "fd09010007ffbe000000000000000608000403990203004036e7bd20e6927ae62a97";
const COMMAND: &str = "fd20010008ffbe4c00000000803f00000000000000000000000000000000000000000000\
                       0000900101011b9703014036e7bd203b3a408a3660";
const WITH_RAW_KEY: &str = "fd02010009ffbe15000001012ea703024036e7bd20e107a75f9943";
/// Unix time of the first frame's stamp [us].
const NOW: u64 = EPOCH_UNIX_US + 36_000_000_000_000 * 10;

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len() / 2).map(|i| u8::from_str_radix(&hex[2 * i..2 * i + 2], 16).unwrap()).collect()
}

fn frame(bytes: &[u8]) -> Frame {
    let mut frames = Vec::new();
    Decoder::new().datagram(bytes, |f| frames.push(f));
    assert_eq!(frames.len(), 1);
    frames.remove(0)
}

fn titan() -> Signing {
    Signing::new(Key::from_passphrase("titan"))
}

#[test]
fn reference_pymavlinks_signatures_are_believed() {
    let mut signing = titan();
    assert_eq!(signing.check(&frame(&bytes(HEARTBEAT)), NOW), Ok(()));
    assert_eq!(signing.check(&frame(&bytes(COMMAND)), NOW), Ok(()));
    let mut raw = Signing::new(Key::from_bytes(std::array::from_fn(|i| i as u8)));
    assert_eq!(raw.check(&frame(&bytes(WITH_RAW_KEY)), NOW), Ok(()));
    assert_eq!(raw.check(&frame(&bytes(COMMAND)), NOW), Err(Refusal::BadSignature));
}

#[test]
fn reference_signed_as_pymavlink_signs() {
    let theirs = bytes(HEARTBEAT);
    let mut ours = theirs[..theirs.len() - SIGNATURE_LEN].to_vec();
    titan().append(&mut ours, 3, NOW);
    assert_eq!(ours, theirs);
}

#[test]
fn any_changed_byte_breaks_the_signature() {
    for at in [HEARTBEAT.len() / 2 - 13, HEARTBEAT.len() / 2 - 8, HEARTBEAT.len() / 2 - 1] {
        let mut changed = bytes(HEARTBEAT);
        changed[at] ^= 1;
        assert_eq!(titan().check(&frame(&changed), NOW), Err(Refusal::BadSignature), "{at}");
    }
}

#[test]
fn what_was_recorded_cannot_be_played_back() {
    let mut signing = titan();
    let (first, second) = (frame(&bytes(HEARTBEAT)), frame(&bytes(COMMAND)));
    assert_eq!(signing.check(&second, NOW), Ok(()));
    assert_eq!(signing.check(&second, NOW), Err(Refusal::Replayed));
    assert_eq!(signing.check(&first, NOW), Err(Refusal::Replayed), "overtaken");
    // A sender that is not known yet: up to a minute old.
    assert_eq!(titan().check(&first, NOW + 60_000_000), Ok(()));
    assert_eq!(titan().check(&first, NOW + 60_000_020), Err(Refusal::Clock(-60)));
}

#[test]
fn unsigned_frames_are_refused() {
    let mut encoder = Encoder::new(51, 68);
    let heartbeat = encoder.encode(&MavMessage::HEARTBEAT(HEARTBEAT_DATA::default()));
    let radio =
        encoder.encode(&MavMessage::RADIO_STATUS(RADIO_STATUS_DATA { rssi: 9, ..Default::default() }));
    assert_eq!(titan().check(&frame(&heartbeat), NOW), Err(Refusal::Unsigned));
    assert_eq!(titan().check(&frame(&radio), NOW), Err(Refusal::Unsigned));
}

#[test]
fn stamps_only_grow_and_follow_nobodys_clock() {
    let stamp = |frame: &[u8]| {
        let at = frame.len() - 12;
        let mut stamp = [0; 8];
        stamp[..6].copy_from_slice(&frame[at..at + 6]);
        u64::from_le_bytes(stamp)
    };
    let mut signing = titan();
    let send = |signing: &mut Signing, now| {
        let mut frame = vec![0; 12];
        signing.append(&mut frame, 0, now);
        stamp(&frame)
    };
    let first = send(&mut signing, NOW);
    assert_eq!(send(&mut signing, NOW), first + 1);
    assert_eq!(send(&mut signing, NOW - 1_000_000), first + 2, "a clock set back");
    // A peer a minute ahead of us: a third party, whose clock is a little behind ours, hears us all the same.
    let ahead = stamped(3, NOW + 60_000_000);
    assert_eq!(signing.check(&ahead, NOW), Ok(()));
    let mut signed = bytes(HEARTBEAT)[..21].to_vec();
    signing.append(&mut signed, 4, NOW);
    assert_eq!(titan().check(&frame(&signed), NOW - 2_000_000), Ok(()));
}

/// A HEARTBEAT as pymavlink's, by its key, signed on a link at a time.
fn stamped(link_id: u8, now: u64) -> Frame {
    let mut signed = bytes(HEARTBEAT)[..21].to_vec();
    titan().append(&mut signed, link_id, now);
    frame(&signed)
}

/// One frame whose stamp was 13 hours ahead, and every station that was not yet known was refused: in this
/// run, and in all others until then.
#[test]
fn regress_who_is_ahead_locks_nobody_else_out() {
    for ahead_s in [61, 600, 13 * 3_600, 23 * 3_600] {
        let mut signing = titan();
        assert_eq!(signing.check(&stamped(3, NOW + ahead_s * 1_000_000), NOW), refused(ahead_s));
        for mut run in [signing.clone(), resumed(&signing, NOW + 1_000_000)] {
            // By a minute either way.
            assert_eq!(run.check(&stamped(4, NOW - 58_000_000), NOW + 1_000_000), Ok(()), "{ahead_s}");
            assert_eq!(run.check(&stamped(5, NOW + 1_000_000), NOW + 1_000_000), Ok(()), "{ahead_s}");
            assert_eq!(run.check(&stamped(3, NOW + 2_000_000), NOW + 1_000_000), Ok(()), "its clock is set");
        }
    }
    // Nor does one who is ahead by less.
    let mut signing = titan();
    assert_eq!(signing.check(&stamped(3, NOW + 60_000_000), NOW), Ok(()));
    for mut run in [signing.clone(), resumed(&signing, NOW)] {
        assert_eq!(run.check(&stamped(4, NOW - 60_000_000), NOW), Ok(()));
    }
}

fn refused(ahead_s: u64) -> Result<(), Refusal> {
    Err(Refusal::Clock(ahead_s.cast_signed()))
}

/// The next run of a party, by what it keeps.
fn resumed(signing: &Signing, now: u64) -> Signing {
    let mut next = titan();
    next.resume(Stamps::parse(&signing.stamps().to_text()).unwrap(), now).unwrap();
    next
}

/// What is kept runs ten seconds ahead of those who are a minute ahead: a start at once goes on from it.
#[test]
fn who_is_a_minute_ahead_lets_us_start_anew() {
    let mut signing = titan();
    assert_eq!(signing.check(&stamped(3, NOW + 60_000_000), NOW), Ok(()));
    assert_eq!(titan().resume(signing.poll_stamps().unwrap(), NOW), Ok(()));
}

#[test]
fn keys_are_read_as_digits_or_passphrase() {
    let digits: String = (0..32).map(|i| format!("{i:02x}")).collect();
    assert!(Key::parse(&format!("{digits}\n")) == Ok(Key::from_bytes(std::array::from_fn(|i| i as u8))));
    assert!(Key::parse("titan\r\n") == Ok(Key::from_passphrase("titan")));
    assert_eq!(Key::parse(&digits[..63]), Err(KeyError::Digits(63)));
    assert!(Key::parse("deadbeef") == Ok(Key::from_passphrase("deadbeef")));
    assert_eq!(Key::parse("\n"), Err(KeyError::Empty));
    assert_eq!(format!("{:?}", Key::from_passphrase("titan")), "Key(..)");
}

/// A key holder's stamp at the end of the 48 bits is refused by name, and ours go on from our clock.
#[test]
fn regress_a_stamp_far_ahead_is_not_followed() {
    let mut signing = titan();
    let mut far = bytes(HEARTBEAT)[..21].to_vec();
    titan().append(&mut far, 3, EPOCH_UNIX_US + (LAST_STAMP - 1) * 10);
    assert!(matches!(signing.check(&frame(&far), NOW), Err(Refusal::Clock(s)) if s > 86_400));
    let mut ours = bytes(HEARTBEAT)[..21].to_vec();
    signing.append(&mut ours, 3, NOW);
    assert_eq!(ours, bytes(HEARTBEAT));
    // A receiver whose clock stands before 2015 believes nothing.
    assert!(matches!(titan().check(&frame(&bytes(HEARTBEAT)), 0), Err(Refusal::Clock(_))));
}

/// More senders than are remembered: new ones are believed, and those forgotten cannot be played back.
#[test]
fn regress_senders_are_bounded_and_nobody_is_locked_out() {
    let (mut signing, mut theirs) = (titan(), titan());
    let mut first = None;
    for i in 0..2 * MAX_STREAMS as u64 {
        let mut signed = bytes(HEARTBEAT)[..21].to_vec();
        theirs.append(&mut signed, (i % 256) as u8, NOW + 20 * i);
        if i >= MAX_STREAMS as u64 {
            signed.truncate(21);
            // Another component: its checksum is made anew.
            signed[6] = 7;
            let crc = mavlink::calculate_crc(&signed[1..19], 50);
            signed[19..21].copy_from_slice(&crc.to_le_bytes());
            theirs.append(&mut signed, (i % 256) as u8, NOW + 20 * i);
        }
        let signed = frame(&signed);
        assert_eq!(signing.check(&signed, NOW + 20 * i), Ok(()), "sender {i}");
        first.get_or_insert(signed);
    }
    assert_eq!(signing.stamps.streams.len(), MAX_STREAMS);
    assert_eq!(signing.check(&first.unwrap(), NOW + 20_000), Err(Refusal::Replayed));
}

/// What was let in once is not let in again after a restart: neither when the last stamps were kept at the
/// end, nor when the party ended without warning.
#[test]
fn stamps_survive_a_restart() {
    let key = Key::from_passphrase("titan");
    let recorded = frame(&bytes(HEARTBEAT));
    let mut before = Signing::new(key);
    assert_eq!(before.poll_stamps(), None);
    assert_eq!(before.check(&recorded, NOW), Ok(()));
    let kept = before.poll_stamps().unwrap();
    assert_eq!(before.poll_stamps(), None, "it is kept");
    for stamps in [&kept, before.stamps()] {
        let stamps = Stamps::parse(&stamps.to_text()).unwrap();
        let mut after = Signing::new(key);
        after.resume(stamps, NOW).unwrap();
        assert_eq!(after.check(&recorded, NOW), Err(Refusal::Replayed));
        assert_eq!(after.poll_stamps(), None);
    }
    // The command has the next stamp: taken after an orderly end, and ten seconds after another.
    let mut orderly = Signing::new(key);
    orderly.resume(before.stamps().clone(), NOW).unwrap();
    assert_eq!(orderly.check(&frame(&bytes(COMMAND)), NOW), Ok(()));
    let later = |s: u64| {
        let mut theirs = Signing::new(key);
        let mut signed = recorded.bytes()[..21].to_vec();
        theirs.append(&mut signed, 3, NOW + s * 1_000_000);
        frame(&signed)
    };
    let mut killed = Signing::new(key);
    killed.resume(kept, NOW).unwrap();
    assert_eq!(killed.check(&later(9), NOW), Err(Refusal::Replayed));
    assert_eq!(killed.check(&later(11), NOW), Ok(()));
}

/// A file of stamps is somebody's to write: it fills no more than the table has room for.
#[test]
fn a_file_of_stamps_holds_no_more_senders_than_are_remembered() {
    let lines = |n: usize| (0..n).map(|i| format!("heard 0 {} {} 1\n", i / 200, i % 200)).collect::<String>();
    assert_eq!(Stamps::parse(&lines(MAX_STREAMS)).unwrap().streams.len(), MAX_STREAMS);
    let error = Stamps::parse(&lines(MAX_STREAMS + 1)).unwrap_err().to_string();
    assert!(error.starts_with("line 257: "), "{error}");
}

#[test]
fn stamps_that_no_clock_follows_are_named() {
    let most = 70_000_000;
    let stamps = Stamps::parse("latest 36000000000000\n").unwrap();
    let resume = |now| Signing::new(Key::from_passphrase("titan")).resume(stamps.clone(), now);
    assert_eq!(resume(NOW - most), Ok(()));
    assert_eq!(resume(NOW - most - 1_000_000), Err(ClockError::Behind(71)));
    assert_eq!(resume(EPOCH_UNIX_US - 1), Err(ClockError::BeforeEpoch));
    for (line, text) in [(1, "latest 281474976710656"), (2, "latest 1\nheard 1 2 3"), (1, "key"), (1, "\n")] {
        let error = Stamps::parse(text).unwrap_err().to_string();
        assert!(error.starts_with(&format!("line {line}: ")), "{error}");
    }
}
