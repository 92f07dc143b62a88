//! Objects of the grasp course, and meaning of the bits and levels of a table.

use atas_core::tasks::BehaviourTable;
use atas_evaluation::trial_seed;
use pinch::{Bit, Interface, Rows, TimeLimit};
use robot_model::HandSide;
use shm_schemas::SensorBit;
use sim_backend::Scene;

use crate::error::{Error, Result};
use crate::evaluate::GoalPoints;
use crate::genome::Genome;

/// Families of objects, one per goal of the paper.
pub const FAMILIES: usize = core::mem::size_of::<GoalPoints>() / core::mem::size_of::<f32>();
/// Sensor bits S1 to S5.
pub const BITS: [SensorBit; 5] = [
    SensorBit::TOUCHING,
    SensorBit::ABOVE_F1,
    SensorBit::SLIPPING,
    SensorBit::ABOVE_F2,
    SensorBit::FRICTION_MARGIN,
];
/// Closing speed of the fingers by level, m/s: hold, open slowly, close slowly (the paper's 2
/// mm/s), close fast.
pub const FINGERS_M_S: [f64; 4] = [0.0, -0.001, 0.002, 0.004];
/// Factor of the hand's speed along its path by level: stop, slowly back, slowly on, full speed.
pub const HAND_SPEED_FACTORS: [f64; 4] = [0.0, -0.1, 0.1, 1.0];
/// Bits of a genome, Eq. (1).
pub const GENOME_BITS: usize = (1 << BITS.len()) * 2 * 2;

/// Members of each family. Design choice: with one, tables adapt to the objects instead of the
/// task.
pub const MEMBERS: usize = 8;

/// Family of objects.
#[derive(Clone, Debug, PartialEq)]
pub struct Family {
    /// Name of its objects in the simulator.
    pub name: String,
    /// Members for the reduced simulation: the built-in object, then random variations with tuning
    /// seeds.
    pub members: [pinch::Object; MEMBERS],
}

/// Returns the eight built-in families.
pub fn families() -> Result<Vec<Family>> {
    let objects = atas_evaluation::Task::Grasp.objects();
    let objects = objects.map_err(Error::from_part)?;
    let family = |object: &sim_backend::Object| Family {
        name: object.name.clone(),
        members: core::array::from_fn(|number| match number as u64 {
            0 => reduced_of(object),
            number => reduced_of(&member(object, number)),
        }),
    };
    Ok(objects.iter().map(family).collect())
}

fn member(object: &sim_backend::Object, seed: u64) -> sim_backend::Object {
    let scene = Scene::grasp(object.clone(), HandSide::Right);
    let drawn = scene.varied(trial_seed(&object.name, seed));
    drawn.objects[0].object.clone()
}

fn reduced_of(object: &sim_backend::Object) -> pinch::Object {
    reduced(
        object.mass_kg,
        object.friction,
        object.stiffness_n_m,
        object.crush_n,
    )
}

/// Converts an object to the reduced simulation.
#[must_use]
pub fn reduced(mass_kg: f64, friction: f64, stiffness_n_m: f64, crush_n: f64) -> pinch::Object {
    /// Stiffness of a rigid object, N/m: it deforms by at most 8 µm.
    const RIGID_N_M: f64 = 1e6;
    pinch::Object {
        mass_kg: mass_kg as f32,
        friction: friction as f32,
        stiffness_n_m: stiffness_n_m.min(RIGID_N_M) as f32,
        crush_n: crush_n as f32,
    }
}

/// Returns the table of a genome: four bits per row, the level of the fingers lowest.
///
/// # Panics
/// Never: every genome of this length is a table.
#[must_use]
pub fn table(genome: &Genome) -> BehaviourTable {
    let rows = (0..1 << BITS.len()).map(|row| {
        let levels = genome.field(4 * row, 4) as usize;
        [levels % 4, levels / 4]
    });
    let rows: Vec<_> = rows.collect();
    BehaviourTable::validated(&BITS, &FINGERS_M_S, &HAND_SPEED_FACTORS, rows.into_iter())
        .expect("two bits select one of four levels")
}

/// Returns the genome of a table with the bits and levels of the course; `None` for other tables.
#[must_use]
pub fn genome(table: &BehaviourTable) -> Option<Genome> {
    let alike = table.bits().eq(BITS)
        && table.fingers_m_s() == FINGERS_M_S
        && table.hand() == HAND_SPEED_FACTORS;
    if !alike {
        return None;
    }
    let mut genome = Genome::zero(GENOME_BITS);
    for row in 0..table.rows() {
        let [fingers, hand] = table.levels(row);
        let levels = fingers | hand << 2;
        (0..4).for_each(|bit| genome.set(4 * row + bit, levels >> bit & 1 == 1));
    }
    Some(genome)
}

/// Returns the rows of a table for the reduced simulation.
#[must_use]
pub fn rows(table: &BehaviourTable) -> Rows {
    table.record().rows
}

/// Returns the bit of the reduced simulation for a sensor bit.
#[must_use]
pub fn reduced_bit(bit: SensorBit) -> Option<Bit> {
    Some(match bit {
        SensorBit::TOUCHING => Bit::Touching,
        SensorBit::ABOVE_F1 => Bit::AboveF1,
        SensorBit::SLIPPING => Bit::Slipping,
        SensorBit::ABOVE_F2 => Bit::AboveF2,
        SensorBit::LIFTED => Bit::Lifted,
        SensorBit::FRICTION_MARGIN => Bit::Spare,
        _ => return None,
    })
}

/// Bits and levels of the course for the reduced simulation.
pub struct Course {
    bits: Vec<Bit>,
}

impl Default for Course {
    fn default() -> Self {
        Self {
            bits: BITS.into_iter().filter_map(reduced_bit).collect(),
        }
    }
}

impl Course {
    /// Returns the interpretation of tables, with or without Module 3.
    #[must_use]
    pub fn interface(&self, force_limit: bool, time_limit: TimeLimit) -> Interface<'_> {
        Interface {
            bits: &self.bits,
            fingers_m_s: FINGERS_M_S.map(|level| level as f32),
            hand: HAND_SPEED_FACTORS.map(|level| level as f32),
            force_limit,
            time_limit,
        }
    }
}
