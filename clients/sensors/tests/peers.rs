//! Emulated peers of every sensor on pseudo-terminals and loopback sockets, with faults: partial
//! reads, junk, loss, reordering, restart, a wrong rate. Real processes, real bus.

mod common;
#[path = "common/peers.rs"]
mod peers;
#[path = "common/process.rs"]
mod process;
#[path = "common/reader.rs"]
mod reader;

use std::net::{TcpListener, UdpSocket};
use std::thread;
use std::time::Duration;

use atas_sensors::calibration::{Calibration, Model, Quality};
use peers::{magnitude, value};
use process::{Pty, Sensor};
use reader::Reader;
use rustix::process::Signal;
use shm_bus::FreshBus;
use shm_schemas::{Hand, HandFrame, Layout};
use tungstenite::Message;

/// Sends pieces across frame boundaries, with pauses.
fn send_in_pieces(pty: &Pty, bytes: &[u8]) {
    let mut rest = bytes;
    for size in (1..90).cycle() {
        let (piece, tail) = rest.split_at(size.min(rest.len()));
        pty.send(piece);
        thread::sleep(Duration::from_micros(200));
        rest = tail;
        if rest.is_empty() {
            break;
        }
    }
}

/// Ends the process, reads its last status on the bus, and returns its standard error.
fn end(sensor: Sensor, reader: &mut Reader) -> String {
    sensor.signal(Signal::TERM);
    let (code, _, stderr) = sensor.finish();
    assert_eq!(code, Some(0), "{stderr}");
    reader.poll();
    stderr
}

fn sequences(frames: &[HandFrame]) -> Vec<u64> {
    frames.iter().map(|frame| frame.stamp.sequence).collect()
}

#[test]
fn polled_paxini_board_survives_partial_reads_junk_and_silence() {
    let bus = FreshBus::new("sensor");
    let mut reader = Reader::new(&bus, Hand::LEFT);
    let pty = Pty::new();
    let sensor = Sensor::start_line(&format!(
        "paxini --device {} --hand left --bus {} --rate-hz 500",
        pty.path.display(),
        *bus
    ));
    for n in 0..100_u32 {
        let request: [u8; 14] = pty.receive();
        assert_eq!(request[..7], [0x55, 0xAA, 9, 0, 1, 0, 0xFB]);
        if n % 10 == 9 {
            continue;
        }
        if n % 4 == 0 {
            pty.send(&[0xAA, 0x55, 0xAA, 0x00]);
        }
        let reply = peers::paxini_reply(n, 31);
        let (first, second) = reply.split_at(1 + n as usize % 90);
        pty.send(first);
        pty.send(second);
        reader.poll();
    }
    reader.wait_for_frames(90);
    let stderr = end(sensor, &mut reader);
    // The last request had no answer, and perhaps those after it.
    assert!(reader.status.lost >= 9, "{stderr}");
    assert_eq!(reader.status.junk_bytes, 25 * 4, "{stderr}");
    let answered: Vec<u32> = (0..100).filter(|n| n % 10 != 9).collect();
    assert_eq!(reader.received.len(), answered.len());
    for (frame, n) in reader.received.iter().zip(answered) {
        let tenths = |index| magnitude(n, index) as f32 * 0.1;
        for taxel in 0..31 {
            let [normal, t1, t2] = frame.force_n[0][taxel];
            let expected = [
                tenths(3 * taxel + 2),
                tenths(3 * taxel),
                tenths(3 * taxel + 1),
            ];
            for (found, expected) in [normal, t1, t2].into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-4, "frame {n}, taxel {taxel}");
            }
        }
        assert_eq!(frame.valid_mask[0], (1 << 31) - 1);
        assert_eq!(
            frame.layout_hash,
            Layout::from_name("pad-31").unwrap().hash()
        );
    }
}

#[test]
fn paxini_hand_board_streams_and_modules_are_separated() {
    let bus = FreshBus::new("sensor");
    let mut reader = Reader::new(&bus, Hand::RIGHT);
    let pty = Pty::new();
    let sensor = Sensor::start_line(&format!(
        "paxini-hand --device {} --hand right --bus {} --modules 31,9,25 --fingertips 0,2 --rate-hz 200",
        pty.path.display(),
        *bus
    ));
    let output: [u8; 20] = pty.receive();
    assert_eq!(output[..9], [0x55, 0xAA, 0, 0x10, 0x16, 0, 1, 0, 3]);
    assert_eq!(output[10..19], [0x55, 0xAA, 0, 0x10, 0x17, 0, 1, 0, 1]);
    let mut stream = Vec::new();
    for n in 0..100_u32 {
        if n % 10 == 0 {
            // A frame of another hand, and a truncated one.
            stream.extend(peers::paxini_hand_frame(n, &[31, 9]));
            stream.extend(&peers::paxini_hand_frame(n, &[31, 9, 25])[..50]);
        }
        stream.extend(peers::paxini_hand_frame(n, &[31, 9, 25]));
    }
    send_in_pieces(&pty, &stream);
    reader.wait_for_frames(100);
    sensor.signal(Signal::TERM);
    let stop: [u8; 10] = pty.receive();
    assert_eq!(stop[..9], [0x55, 0xAA, 0, 0x10, 0x17, 0, 1, 0, 0]);
    let (code, _, stderr) = sensor.finish();
    assert_eq!(code, Some(0), "{stderr}");
    reader.poll();
    let other = peers::paxini_hand_frame(0, &[31, 9]).len() as u64;
    assert_eq!(reader.status.junk_bytes, 10 * (other + 50), "{stderr}");
    assert_eq!(sequences(&reader.received), (0..100).collect::<Vec<_>>());
    for (frame, n) in reader.received.iter().zip(0..) {
        for (finger, first, taxels) in [(0, 0, 31), (1, 40, 25)] {
            for taxel in 0..31 {
                let tenths = |axis| match taxel < taxels {
                    true => magnitude(n, 3 * (first + taxel) + axis) as f32 * 0.1,
                    false => 0.0,
                };
                let expected = [tenths(2), tenths(0), tenths(1)];
                for (found, expected) in frame.force_n[finger][taxel].into_iter().zip(expected) {
                    assert!(
                        (found - expected).abs() < 1e-4,
                        "frame {n}, finger {finger}"
                    );
                }
            }
        }
        assert_eq!(frame.valid_mask, [(1 << 31) - 1, (1 << 31) - 1, 0, 0]);
    }
}

#[test]
fn excess_taxels_become_one_force() {
    let bus = FreshBus::new("sensor");
    let mut reader = Reader::new(&bus, Hand::LEFT);
    let folder = tempfile::tempdir().unwrap();
    let (file, pty) = (folder.path().join("tip.toml"), Pty::new());
    // Half a newton per unit of every taxel: z along the normal, x and y along the tangents.
    let row = |axis: usize| {
        (0..3 * 87)
            .map(|k| 0.5 * f64::from(k % 3 == axis))
            .collect()
    };
    let calibration = Calibration {
        format: 1,
        source: "sums".to_owned(),
        model: Model::Resultant,
        zero: vec![0.0; 3 * 87],
        newtons: vec![[row(2), row(0), row(1)]],
        quality: Quality::default(),
        drift: None,
    };
    calibration.save(&file).unwrap();
    let line = format!(
        "paxini-hand --device {} --hand left --bus {} --modules 87",
        pty.path.display(),
        *bus
    );
    let (code, _, stderr) = Sensor::start_line(&line).finish();
    assert_eq!(code, Some(2), "{stderr}");
    assert!(
        stderr.contains("64 elements") && stderr.contains("--calibration"),
        "{stderr}"
    );
    let sensor = Sensor::start_line(&format!("{line} --calibration {}", file.display()));
    reader.wait_for_start();
    for n in 0..20 {
        pty.send(&peers::paxini_hand_frame(n, &[87]));
    }
    reader.wait_for_frames(20);
    let stderr = end(sensor, &mut reader);
    assert_eq!(reader.received.len(), 20, "{stderr}");
    for (frame, n) in reader.received.iter().zip(0..) {
        let sum = |axis: usize| {
            (0..87)
                .map(|taxel| magnitude(n, 3 * taxel + axis))
                .sum::<i32>()
        };
        let expected = [sum(2), sum(0), sum(1)].map(|sum| sum as f32 * 0.5);
        assert_eq!(frame.force_n[0][0], expected, "frame {n}");
        assert_eq!(frame.valid_mask, [1, 0, 0, 0]);
    }
}

#[test]
fn anyskin_board_resynchronises_and_zeroes() {
    let bus = FreshBus::new("sensor");
    let mut reader = Reader::new(&bus, Hand::RIGHT);
    let pty = Pty::new();
    let sensor = Sensor::start_line(&format!(
        "anyskin --device {} --hand right --bus {} --zero --newtons-per-count 0.5,0.5,0.5",
        pty.path.display(),
        *bus
    ));
    reader.wait_for_start();
    let mut stream = b"Scanning I2C\r\nInit MLX90393\r\n".to_vec();
    let boot = stream.len() as u64;
    // Fewer frames than a reader's buffer holds.
    for n in 0..170_u32 {
        // The same field during the zero, then others.
        stream.extend(peers::anyskin_frame(if n < 50 { 7 } else { n }));
        if n % 30 == 29 {
            stream.extend(&peers::anyskin_frame(n)[..40]);
        }
    }
    send_in_pieces(&pty, &stream);
    reader.wait_for_frames(170);
    let stderr = end(sensor, &mut reader);
    assert_eq!(reader.status.junk_bytes, boot + 5 * 40, "{stderr}");
    assert_eq!(reader.received.len(), 120);
    for (frame, n) in reader.received.iter().zip(50..) {
        let newtons = |index| (value(n, index) - value(7, index)) as f32 * 0.5;
        assert_eq!(
            frame.force_n[0][4],
            [newtons(14), newtons(12), newtons(13)],
            "frame {n}"
        );
    }
}

#[test]
fn papillarray_controller_survives_loss_and_restart() {
    let bus = FreshBus::new("sensor");
    let mut reader = Reader::new(&bus, Hand::LEFT);
    let pty = Pty::new();
    let sensor = Sensor::start_line(&format!(
        "papillarray --device {} --hand left --bus {} --sensors 2 --rate-hz 250 --zero",
        pty.path.display(),
        *bus
    ));
    assert_eq!(&pty.receive::<7>(), b"f250\nz\n");
    // Two packets lost, one whose sum is wrong, and a controller that restarts its counter. It
    // sends faster than requested.
    let mut corrupt = peers::papillarray_packet(5120, 2);
    corrupt[200] ^= 1;
    let mut stream = Vec::new();
    for n in (5000..5100).chain(5102..5120) {
        stream.extend(peers::papillarray_packet(n, 2));
    }
    stream.extend(corrupt);
    for n in (5121..5130).chain(0..20) {
        stream.extend(peers::papillarray_packet(n, 2));
    }
    send_in_pieces(&pty, &stream);
    reader.wait_for_frames(147);
    let stderr = end(sensor, &mut reader);
    assert!(
        stderr.contains("147 frames, 3 lost, 0 duplicates, 0 late, 1 restarts"),
        "{stderr}"
    );
    assert_eq!(
        (reader.status.lost, reader.status.checksum_failures),
        (3, 1)
    );
    let last = reader.received.last().unwrap();
    let newtons = |index| value(19, index) as f32 / 8.0;
    let pillar = |n: usize| [newtons(3 * n + 2), newtons(3 * n), newtons(3 * n + 1)];
    assert_eq!((last.finger_count, last.force_n[1][8]), (2, pillar(17)));
    assert_eq!(last.stamp.sequence, 5129 - 5000 + 20);
}

#[test]
fn net_ft_box_survives_loss_reordering_and_restart() {
    let bus = FreshBus::new("sensor");
    let mut reader = Reader::new(&bus, Hand::LEFT);
    let peer = UdpSocket::bind("127.0.0.1:0").unwrap();
    peer.set_read_timeout(Some(Duration::from_secs(30)))
        .unwrap();
    let sensor = Sensor::start_line(&format!(
        "netft --device {} --hand left --bus {} --newtons-per-count 1/1000,1/1000,1/1000 --axes x,y,z",
        peer.local_addr().unwrap(),
        *bus
    ));
    let mut request = [0; 16];
    let begun = [0x12, 0x34, 0, 2, 0, 0, 0, 0];
    // The first request is lost; the driver repeats it.
    for _ in 0..2 {
        let (length, from) = peer.recv_from(&mut request).unwrap();
        assert_eq!(request[..length], begun);
        peer.connect(from).unwrap();
    }
    let send = |sequence: u32| peer.send(&peers::netft_record(sequence)).unwrap();
    // Across the wrap: one lost, two swapped, one duplicate, a short one, and two in one datagram.
    let start = u32::MAX - 2;
    for step in [0, 1, 2, 3, 5, 7, 6, 8, 8] {
        send(start.wrapping_add(step));
    }
    peer.send(&peers::netft_record(9)[..35]).unwrap();
    let pair = [9, 10].map(|step| peers::netft_record(start.wrapping_add(step)));
    peer.send(&pair.concat()).unwrap();
    reader.wait_for_frames(11);
    // The box restarts: silence until the next request, then counts from 1.
    let (length, _) = peer.recv_from(&mut request).unwrap();
    assert_eq!(request[..length], begun);
    for sequence in 1..=5 {
        send(sequence);
    }
    reader.wait_for_frames(16);
    let stderr = end(sensor, &mut reader);
    assert!(
        stderr.contains("16 frames, 1 lost, 1 duplicates, 1 late, 1 restarts"),
        "{stderr}"
    );
    assert!(stderr.contains("35 junk, 1 checksum failures"), "{stderr}");
    let (length, _) = peer.recv_from(&mut request).unwrap();
    assert_eq!(request[..length], [0x12, 0x34, 0, 0, 0, 0, 0, 0]);
    assert_eq!(
        sequences(&reader.received),
        [0, 1, 2, 3, 5, 7, 8, 9, 10, 11, 12, 13, 14, 15]
    );
    let newtons = |axis| value(5, axis) as f32;
    assert_eq!(
        reader.received.last().unwrap().force_n[0][0],
        [newtons(0), newtons(1), newtons(2)]
    );
}

#[test]
fn uskin_server_survives_invalid_text_and_restart() {
    let bus = FreshBus::new("sensor");
    let mut reader = Reader::new(&bus, Hand::LEFT);
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let sensor = Sensor::start_line(&format!(
        "uskin --device ws://{} --hand left --bus {} --newtons-per-count 0.001,0.001,0.001 --reconnect",
        listener.local_addr().unwrap(),
        *bus
    ));
    let accept = || tungstenite::accept(listener.accept().unwrap().0).unwrap();
    let text = |n: u32| Message::text(String::from_utf8(peers::uskin_update(n)).unwrap());
    let mut server = accept();
    server
        .send(Message::text(r#"{"message":"Welcome"}"#))
        .unwrap();
    for n in [100, 101, 103, 102, 104] {
        server.send(text(n)).unwrap();
    }
    let cut = String::from_utf8(peers::uskin_update(105)).unwrap();
    server.send(Message::text(&cut[..100])).unwrap();
    server.send(Message::text("[]")).unwrap();
    reader.wait_for_frames(5);
    drop(server);
    let mut server = accept();
    server.send(text(106)).unwrap();
    reader.wait_for_frames(6);
    let stderr = end(sensor, &mut reader);
    assert!(
        stderr.contains("6 frames, 1 lost, 0 duplicates, 1 late"),
        "{stderr}"
    );
    assert!(stderr.contains("102 junk, 2 checksum failures"), "{stderr}");
    assert_eq!(sequences(&reader.received), [0, 1, 3, 4, 6]);
    let counts = |index| (0x8000 + value(106, index)) as f32 * 0.001;
    let [normal, ..] = reader.received.last().unwrap().force_n[0][15];
    assert!((normal - counts(47)).abs() < 1e-3);
}
