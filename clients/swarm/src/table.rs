//! Behaviour table: sensor truth values in, motor states out (paper III.a, Table 1), for any number
//! of sensors, motors and bits per motor.

use crate::genome::Genome;

/// Dimensions of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Shape {
    /// Boolean sensors, at most 16.
    pub sensors: usize,
    /// Motors.
    pub motors: usize,
    /// Output bits per motor.
    pub bits: usize,
}

impl Shape {
    /// The paper's agent: five sensors, two wheel motors of two bits, 128 bits in total (paper
    /// III.a).
    pub const MOBILE_ROBOT: Self = Self {
        sensors: 5,
        motors: 2,
        bits: 2,
    };

    /// Returns the number of rows: one per combination of the sensors.
    #[must_use]
    pub const fn rows(self) -> usize {
        1 << self.sensors
    }

    /// Returns the output bits of one row.
    #[must_use]
    pub const fn row_bits(self) -> usize {
        self.motors * self.bits
    }

    /// Returns the length of the genotype array, Eq. (1): G = 2^S · Σ Mⱼ Eⱼ.
    #[must_use]
    pub const fn genome_bits(self) -> usize {
        self.rows() * self.row_bits()
    }
}

/// Behaviour table. Row r = S1 + 2·S2 + 4·S3 + …; within a row, motor by motor, bit by bit (L1 L2
/// R1 R2).
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Table {
    shape: Shape,
    genome: Genome,
}

impl Table {
    /// Returns the table that a genome encodes from bit `first` on.
    #[must_use]
    pub fn from_genome(shape: Shape, genome: &Genome, first: usize) -> Self {
        let mut own = Genome::zero(shape.genome_bits());
        for bit in 0..own.len() {
            own.set(bit, genome.get(first + bit));
        }
        Self { shape, genome: own }
    }

    /// Builds a table from the level of every row and motor. A level sets that number of the
    /// motor's bits, the last ones first, as the paper writes medium speed in Table 1 (0 1).
    #[must_use]
    pub fn from_levels(shape: Shape, mut level: impl FnMut(usize, usize) -> usize) -> Self {
        let mut genome = Genome::zero(shape.genome_bits());
        for row in 0..shape.rows() {
            for motor in 0..shape.motors {
                for bit in (0..shape.bits).rev().take(level(row, motor)) {
                    genome.set(row * shape.row_bits() + motor * shape.bits + bit, true);
                }
            }
        }
        Self { shape, genome }
    }

    /// Returns the dimensions.
    #[must_use]
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// Returns the output bits of a row, the first motor's first bit lowest: L1, L2, R1, R2 for the
    /// mobile robot.
    #[must_use]
    pub fn output(&self, row: usize) -> u32 {
        self.genome.field(
            row % self.shape.rows() * self.shape.row_bits(),
            self.shape.row_bits(),
        )
    }

    /// Returns the level of one motor in a row: the number of its set bits (paper Table 1: 0 stop,
    /// 1 medium, 2 high).
    #[must_use]
    pub fn level(&self, row: usize, motor: usize) -> usize {
        let first = row * self.shape.row_bits() + motor * self.shape.bits;
        self.genome.field(first, self.shape.bits).count_ones() as usize
    }

    /// Returns the table as a genotype array.
    #[must_use]
    pub fn genome(&self) -> &Genome {
        &self.genome
    }
}

/// Returns a two-wheel behaviour in the paper's words (table after Fig. 15). Equal levels go
/// straight; a faster right wheel turns left.
#[must_use]
pub fn behaviour(left: usize, right: usize) -> &'static str {
    match (left, right) {
        (0, 0) => "Stop",
        (1, 1) => "Go straight",
        (_, _) if left == right => "Go straight fast",
        (_, _) if left < right => "Turn left",
        _ => "Turn right",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn genome_length_follows_equation_1() {
        assert_eq!(Shape::MOBILE_ROBOT.genome_bits(), 128);
        assert_eq!(
            Shape {
                sensors: 3,
                motors: 4,
                bits: 3
            }
            .genome_bits(),
            96
        );
        assert_eq!(
            Shape {
                sensors: 0,
                motors: 1,
                bits: 1
            }
            .genome_bits(),
            1
        );
    }

    #[test]
    fn levels_round_trip_in_any_shape() {
        for shape in [
            Shape::MOBILE_ROBOT,
            Shape {
                sensors: 3,
                motors: 4,
                bits: 3,
            },
            Shape {
                sensors: 6,
                motors: 1,
                bits: 5,
            },
        ] {
            let level = |row: usize, motor: usize| (row * 7 + motor * 3) % (shape.bits + 1);
            let table = Table::from_levels(shape, level);
            for row in 0..shape.rows() {
                for motor in 0..shape.motors {
                    assert_eq!(
                        table.level(row, motor),
                        level(row, motor),
                        "{shape:?} row {row} motor {motor}"
                    );
                }
            }
            assert_eq!(Table::from_genome(shape, table.genome(), 0), table);
        }
    }

    #[test]
    fn medium_speed_is_either_bit() {
        let mut genome = Genome::zero(128);
        genome.set(0, true); // row 0: L1
        genome.set(5, true); // row 1: L2
        let table = Table::from_genome(Shape::MOBILE_ROBOT, &genome, 0);
        assert_eq!(
            [table.level(0, 0), table.level(1, 0), table.level(0, 1)],
            [1, 1, 0]
        );
        assert_eq!([table.output(0), table.output(1)], [0b0001, 0b0010]);
    }
}
