//! The checksum detects every flipped bit.

use shm_schemas::{Hand, HandFrame, JointCommand, JointState, Layout, Stamp};
use zerocopy::{FromBytes, IntoBytes};

fn command() -> JointCommand {
    let mut command = JointCommand {
        stamp: Stamp {
            sequence: 7,
            captured_ns: 1_234_567,
            writer_epoch: 42,
        },
        joint_count: 22,
        position: std::array::from_fn(|i| 0.1 * i as f64 - 1.0),
        ..JointCommand::default()
    };
    command.seal();
    command
}

fn frame() -> HandFrame {
    let mut frame = HandFrame {
        layout_hash: Layout::dome_41().hash(),
        hand: Hand::RIGHT,
        finger_count: 2,
        ..HandFrame::default()
    };
    frame.force_n[1][40] = [1.5, -0.25, 0.125];
    frame.seal();
    frame
}

/// Every bit at this distance; fewer under Miri, which is a thousand times slower.
fn bits(bytes: &[u8], step: usize) -> impl Iterator<Item = usize> + use<> {
    (0..8 * bytes.len()).step_by(if cfg!(miri) { 2003 } else { step })
}

#[test]
fn every_flipped_command_bit_is_detected() {
    let sound = command();
    assert!(sound.is_intact());
    let mut bytes = sound.as_bytes().to_vec();
    for bit in bits(&bytes, 1) {
        bytes[bit / 8] ^= 1 << (bit % 8);
        assert!(
            !JointCommand::read_from_bytes(&bytes).unwrap().is_intact(),
            "bit {bit}"
        );
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
    assert!(JointCommand::read_from_bytes(&bytes).unwrap().is_intact());
}

#[test]
fn flipped_joint_state_bits_are_detected() {
    let mut state = JointState {
        joint_count: 22,
        commanded_count: 22,
        commanded_position: std::array::from_fn(|i| 0.1 * i as f64 - 1.0),
        command_epoch: 42,
        ..JointState::default()
    };
    assert!(!state.is_intact(), "an unsealed state is not intact");
    state.seal();
    let mut bytes = state.as_bytes().to_vec();
    for bit in bits(&bytes, 1) {
        bytes[bit / 8] ^= 1 << (bit % 8);
        let read = JointState::read_from_bytes(&bytes).unwrap();
        assert!(!read.is_intact(), "bit {bit}");
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
}

#[test]
fn flipped_frame_bits_are_detected() {
    let mut bytes = frame().as_bytes().to_vec();
    // 101 is coprime to the length, so the samples cover all kinds of bytes and all bit positions.
    for bit in bits(&bytes, 101) {
        bytes[bit / 8] ^= 1 << (bit % 8);
        assert!(
            !HandFrame::read_from_bytes(&bytes).unwrap().is_intact(),
            "bit {bit}"
        );
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
}

#[test]
fn a_seal_is_the_standard_crc_of_everything_before_it() {
    let frame = frame();
    let covered = size_of::<HandFrame>() - 4;
    assert_eq!(frame.crc32, crc32_bitwise(&frame.as_bytes()[..covered]));
    assert_eq!(crc32_bitwise(b"123456789"), 0xcbf4_3926);
}

#[test]
fn an_unsealed_payload_is_not_intact() {
    assert!(
        !HandFrame {
            finger_count: 2,
            ..HandFrame::default()
        }
        .is_intact()
    );
    assert!(
        !JointCommand {
            joint_count: 22,
            ..JointCommand::default()
        }
        .is_intact()
    );
}

/// Independent bitwise CRC-32 (IEEE 802.3, reflected, as in zlib).
fn crc32_bitwise(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| {
            (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg())
        })
    })
}
