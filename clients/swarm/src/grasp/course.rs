//! What is grasped, and what the bits and levels of a table mean.

use atas_core::tasks::BehaviourTable;
use atas_evaluation::trial_seed;
use pinch::{Bit, Interface, Patience, Rows};
use robot_model::Side;
use shm_schemas::SensorBit;
use sim_backend::Scene;

use crate::error::{Error, Result};
use crate::evaluate::GoalPoints;
use crate::genome::Genome;

/// Families of objects, as the paper has goals.
pub const FAMILIES: usize = core::mem::size_of::<GoalPoints>() / core::mem::size_of::<f32>();
/// The sensor bits, S1 to S5.
pub const BITS: [SensorBit; 5] = [
    SensorBit::TOUCHING,
    SensorBit::ABOVE_F1,
    SensorBit::SLIPPING,
    SensorBit::ABOVE_F2,
    SensorBit::SPARE,
];
/// Closing speed of the fingers by level, m/s: hold, open slowly, close slowly (the paper's 2 mm/s), close fast.
pub const FINGERS_M_S: [f64; 4] = [0.0, -0.001, 0.002, 0.004];
/// Factor on the hand's speed along its way by level: stand, back slowly, slowly, at full speed.
pub const HAND: [f64; 4] = [0.0, -0.1, 0.1, 1.0];
/// Bits of a genome: Eq. 1.
pub const GENOME_BITS: usize = (1 << BITS.len()) * 2 * 2;

/// Members of each family that a table is tried on (ours: with one, tables learn the objects and not the task).
pub const MEMBERS: usize = 8;

/// A family of objects of the course.
#[derive(Clone, Debug, PartialEq)]
pub struct Family {
    /// The name of its objects in the simulator.
    pub name: String,
    /// What the reduced simulation knows of its members: the built-in object, then such as are drawn by tuning seeds.
    pub members: [pinch::Object; MEMBERS],
}

/// The eight families of the built-in set.
///
/// # Errors
/// A built-in object's file is wrong.
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

/// The member of a family that an evaluation draws by this seed.
fn member(object: &sim_backend::Object, seed: u64) -> sim_backend::Object {
    let scene = Scene::grasp(object.clone(), Side::Right);
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

/// An object as the reduced simulation has it.
#[must_use]
pub fn reduced(mass_kg: f64, friction: f64, stiffness_n_m: f64, crush_n: f64) -> pinch::Object {
    /// What stands for a rigid object, N/m: it gives way by 8 µm at most.
    const RIGID_N_M: f64 = 1e6;
    pinch::Object {
        mass_kg: mass_kg as f32,
        friction: friction as f32,
        stiffness_n_m: stiffness_n_m.min(RIGID_N_M) as f32,
        crush_n: crush_n as f32,
    }
}

/// The table of a genome: four bits per row, the fingers' level lowest.
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
    BehaviourTable::checked(&BITS, &FINGERS_M_S, &HAND, rows.into_iter())
        .expect("two bits name one of four levels")
}

/// The genome of a table with the bits and levels of the course; nothing for another.
#[must_use]
pub fn genome(table: &BehaviourTable) -> Option<Genome> {
    let alike = table.bits().eq(BITS) && table.fingers_m_s() == FINGERS_M_S && table.hand() == HAND;
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

/// A table's rows as the reduced simulation reads them.
#[must_use]
pub fn rows(table: &BehaviourTable) -> Rows {
    table.record().rows
}

/// A sensor bit as the reduced simulation has it.
#[must_use]
pub fn reduced_bit(bit: SensorBit) -> Option<Bit> {
    Some(match bit {
        SensorBit::TOUCHING => Bit::Touching,
        SensorBit::ABOVE_F1 => Bit::AboveF1,
        SensorBit::SLIPPING => Bit::Slipping,
        SensorBit::ABOVE_F2 => Bit::AboveF2,
        SensorBit::LIFTED => Bit::Lifted,
        SensorBit::SPARE => Bit::Spare,
        _ => return None,
    })
}

/// The course's bits and levels, as the reduced simulation has them.
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
    /// What tables of the course mean; with Module 3 beside them or alone.
    #[must_use]
    pub fn interface(&self, force_limit: bool, patience: Patience) -> Interface<'_> {
        Interface {
            bits: &self.bits,
            fingers_m_s: FINGERS_M_S.map(|level| level as f32),
            hand: HAND.map(|level| level as f32),
            force_limit,
            patience,
        }
    }
}
