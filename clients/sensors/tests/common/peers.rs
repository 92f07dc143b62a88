//! Emulated devices: messages made from the format descriptions, independent of the code under
//! test.
#![allow(dead_code, reason = "each program uses its own part")]

/// Returns taxel values that follow from a frame's number, so that a wrong frame is detected.
pub(crate) fn value(frame: u32, index: usize) -> i32 {
    let mixed = frame
        .wrapping_mul(2_654_435_761)
        .wrapping_add(index as u32 * 40_503);
    (mixed >> 16) as i32 % 120
}

/// Returns non-negative taxel values that follow from a frame's number.
pub(crate) fn magnitude(frame: u32, index: usize) -> i32 {
    value(frame, index).abs()
}

/// Reply of a Paxini board to a read of all taxels.
pub(crate) fn paxini_reply(frame: u32, taxels: usize) -> Vec<u8> {
    let data: Vec<u8> = (0..3 * taxels)
        .map(|index| magnitude(frame, index) as u8)
        .collect();
    let length = (data.len() + 10) as u16;
    let mut bytes = vec![0xAA, 0x55];
    bytes.extend(length.to_le_bytes());
    bytes.extend([1, 0, 0xFB, 0x0E, 0x04, 0, 0]);
    bytes.extend((data.len() as u16).to_le_bytes());
    bytes.push(1);
    bytes.extend(data);
    let sum = bytes.iter().map(|&b| u32::from(b)).sum::<u32>() as u8;
    bytes.push(sum.wrapping_neg());
    bytes
}

/// A frame of an AnySkin board with five magnetometers.
pub(crate) fn anyskin_frame(frame: u32) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(82);
    for chip in 0..5 {
        bytes.extend(25.5_f32.to_le_bytes());
        for axis in 0..3 {
            bytes.extend((value(frame, 3 * chip + axis) as f32).to_le_bytes());
        }
    }
    bytes.extend(b"\r\n");
    bytes
}

/// A packet of a PapillArray controller with every block that it sends.
pub(crate) fn papillarray_packet(frame: u32, sensors: usize) -> Vec<u8> {
    let count = sensors as u16;
    let offsets = |size: usize, several: usize, first: usize| {
        (0..several).flat_map(move |n| ((first + n * size) as u16).to_le_bytes())
    };
    let mut hub = frame.to_le_bytes().to_vec();
    hub.extend((u64::from(frame) * 1000).to_le_bytes());
    let mut pillars = count.to_le_bytes().to_vec();
    pillars.extend(offsets(254, sensors, 2 + 2 * sensors));
    for sensor in 0..sensors {
        pillars.extend(9_u16.to_le_bytes());
        pillars.extend(offsets(26, 9, 20));
        for pillar in 0..9 {
            pillars.extend(2_u16.to_le_bytes());
            for axis in 0..6 {
                let index = (sensor * 9 + pillar) * 3 + axis % 3;
                pillars.extend((value(frame, index) as f32 / 8.0).to_le_bytes());
            }
        }
    }
    let mut global = count.to_le_bytes().to_vec();
    global.extend(offsets(26, sensors, 2 + 2 * sensors));
    for _ in 0..sensors {
        global.extend(2_u16.to_le_bytes());
        global.extend([0; 24]);
    }
    let blocks = [(1_u16, hub), (3, pillars), (4, global)];
    let mut body = vec![2];
    let mut at = 1 + 4 * blocks.len();
    for (kind, block) in &blocks {
        body.extend(kind.to_le_bytes());
        body.extend((at as u16).to_le_bytes());
        at += block.len();
    }
    body.extend(blocks.into_iter().flat_map(|(_, block)| block));
    let sum = body.iter().map(|&b| u32::from(b)).sum::<u32>() as u16;
    let mut packet = vec![0x55, 0x66, 0x77, 0x88];
    packet.extend(body);
    packet.extend(sum.to_le_bytes());
    packet.extend([0xAA, 0xBB, 0xCC, 0xDD]);
    packet
}

/// A record of a Net F/T box.
pub(crate) fn netft_record(sequence: u32) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(36);
    for word in [sequence, sequence.wrapping_mul(7), 0] {
        bytes.extend(word.to_be_bytes());
    }
    for axis in 0..6 {
        bytes.extend((value(sequence, axis) * 1000).to_be_bytes());
    }
    bytes
}

/// An update of a uSkin server with one pad of sixteen taxels.
pub(crate) fn uskin_update(message: u32) -> Vec<u8> {
    let words: Vec<String> = (0..48)
        .map(|index| format!("{:04X}", 0x8000 + value(message, index)))
        .collect();
    format!(
        r#"{{"message":{message},"1":{{"sensor":"1","model":"uSPa44","taxels":16,"data":"{}"}}}}"#,
        words.join(",")
    )
    .into_bytes()
}

/// A frame of a Paxini high-speed board, of modules with these numbers of taxels.
pub(crate) fn paxini_hand_frame(frame: u32, modules: &[usize]) -> Vec<u8> {
    let mut data = Vec::new();
    let mut index = 0;
    for taxels in modules {
        data.extend([1, 0, 2, 0, 3, 0]);
        for _ in 0..3 * taxels {
            data.push(magnitude(frame, index) as u8);
            index += 1;
        }
    }
    let mut bytes = vec![0xAA, 0x56, 0];
    bytes.extend((data.len() as u16 + 1).to_le_bytes());
    bytes.push(0);
    bytes.extend(data);
    let sum = bytes.iter().map(|&b| u32::from(b)).sum::<u32>() as u8;
    bytes.push(sum.wrapping_neg());
    bytes
}

/// A frame of an OptoForce dome.
pub(crate) fn optoforce_frame(frame: u32) -> Vec<u8> {
    let mut bytes = vec![0xAA, 0x07, 0x08, 0x0A];
    bytes.extend((frame as u16).to_be_bytes());
    bytes.extend([0, 0]);
    for axis in 0..3 {
        bytes.extend((value(frame, axis) as i16).to_be_bytes());
    }
    let sum: u16 = bytes.iter().map(|&b| u16::from(b)).sum();
    bytes.extend(sum.to_be_bytes());
    bytes
}

/// Frame `n` of the sensor with this name, default options.
pub(crate) fn frame(sensor: &str, n: u32) -> Vec<u8> {
    match sensor {
        "optoforce" => optoforce_frame(n),
        "paxini" => paxini_reply(n, 31),
        "paxini-hand" => paxini_hand_frame(n, &[31]),
        "anyskin" => anyskin_frame(n),
        "netft" => netft_record(n),
        "uskin" => uskin_update(n),
        "papillarray" => papillarray_packet(n, 1),
        other => panic!("no peer for {other}: add one to tests/common/peers.rs"),
    }
}
