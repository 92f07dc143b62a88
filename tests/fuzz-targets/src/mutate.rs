//! Mutator: changes an input by bits, bytes, numbers, blocks and words.

use crate::random::Random;

/// Words that text readers treat specially.
const WORDS: [&[u8]; 24] = [
    b"0",
    b"-1",
    b"1e308",
    b"-1e999",
    b"nan",
    b"inf",
    b"18446744073709551615",
    b"99999999999999999999999",
    b"9223372036854775808",
    b"-9223372036854775808",
    b"0.0000000000000000001",
    b"\"\"",
    b"''",
    b"[]",
    b"{}",
    b"[[[[[[[[",
    b"true",
    b"null",
    b"\n",
    b"\r\n\r\n",
    b"\xff\xff",
    b"\0",
    b"=",
    b".",
];

/// Numbers at which counters and lengths wrap.
const BYTES: [u8; 8] = [0, 1, 2, 0x7F, 0x80, 0xFE, 0xFF, b'9'];

/// Returns a mutation of one of the seeds, of at most `length_max` bytes.
#[must_use]
pub fn mutated(seeds: &[Vec<u8>], length_max: usize, random: &mut Random) -> Vec<u8> {
    let mut bytes = pick(seeds, random).to_vec();
    // Mostly few changes: many of them rarely pass the first check.
    let changes = 1 << random.below(6);
    for _ in 0..=random.below(changes) {
        change(&mut bytes, seeds, random);
    }
    bytes.truncate(length_max);
    bytes
}

fn pick<'a>(seeds: &'a [Vec<u8>], random: &mut Random) -> &'a [u8] {
    seeds
        .get(random.below(seeds.len()))
        .map_or(&[], Vec::as_slice)
}

fn change(bytes: &mut Vec<u8>, seeds: &[Vec<u8>], random: &mut Random) {
    let place = random.below(bytes.len());
    let kind = random.below(12);
    match (kind, bytes.get_mut(place)) {
        (0 | 1, Some(byte)) => *byte ^= 1 << random.below(8),
        (2, Some(byte)) => *byte = random.next() as u8,
        (3, Some(byte)) => *byte = BYTES[random.below(BYTES.len())],
        (4, Some(byte)) => {
            let step = random.below(17) as u8;
            *byte = byte.wrapping_add(step).wrapping_sub(8);
        }
        (5, Some(_)) => overwrite(bytes, place, &random.next().to_le_bytes(), random),
        (6, Some(_)) => {
            let block = block(bytes, random);
            bytes.drain(block);
        }
        (7, Some(_)) => {
            let copy = bytes[block(bytes, random)].to_vec();
            insert(bytes, place, &copy);
        }
        (8, Some(_)) => number(bytes, place, random),
        (9, _) => insert(bytes, place, WORDS[random.below(WORDS.len())]),
        (10, _) => {
            let other = pick(seeds, random);
            let copy = other[block(other, random)].to_vec();
            insert(bytes, place, &copy);
        }
        (11, Some(_)) => bytes.truncate(place),
        _ => bytes.extend(random.next().to_le_bytes()),
    }
}

/// Replaces the decimal number at or after a place.
fn number(bytes: &mut Vec<u8>, place: usize, random: &mut Random) {
    let is_digit = |byte: &u8| byte.is_ascii_digit() || b".+-e".contains(byte);
    let Some(begin) = bytes[place..].iter().position(u8::is_ascii_digit) else {
        return overwrite(bytes, place, WORDS[random.below(11)], random);
    };
    let begin = place + begin;
    let length = bytes[begin..]
        .iter()
        .take_while(|byte| is_digit(byte))
        .count();
    bytes.splice(
        begin..begin + length,
        WORDS[random.below(11)].iter().copied(),
    );
}

fn block(bytes: &[u8], random: &mut Random) -> core::ops::Range<usize> {
    let begin = random.below(bytes.len());
    let longest = 1 << random.below(8);
    begin..bytes.len().min(begin + random.below(longest) + 1)
}

fn insert(bytes: &mut Vec<u8>, place: usize, new: &[u8]) {
    bytes.splice(place..place, new.iter().copied());
}

/// Overwrites one, two, four or eight bytes.
fn overwrite(bytes: &mut [u8], place: usize, with: &[u8], random: &mut Random) {
    let end = bytes.len().min(place + (1 << random.below(4)));
    for (byte, new) in bytes[place..end].iter_mut().zip(with) {
        *byte = *new;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mutations_follow_from_the_seed() {
        let seeds = [b"a = 1.5\n".to_vec(), Vec::new(), vec![0xFF; 300]];
        let of = |seed| {
            let inputs = (0..2000).map(|n| mutated(&seeds, 256, &mut Random::new(seed, n)));
            inputs.collect::<Vec<_>>()
        };
        assert_eq!(of(1), of(1));
        assert_ne!(of(1), of(2));
        assert!(of(3).iter().all(|input| input.len() <= 256));
        assert!(of(3).iter().any(|input| input.starts_with(b"a = ")));
    }

    #[test]
    fn mutation_without_seeds_is_possible() {
        let inputs = (0..100).map(|n| mutated(&[], 64, &mut Random::new(0, n)));
        assert!(
            inputs
                .max_by_key(Vec::len)
                .is_some_and(|input| !input.is_empty())
        );
    }
}
