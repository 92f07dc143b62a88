//! Harm to the objects, by ground truth.

use shm_schemas::{ObjectTruth, WorldTruth};

use crate::allowance::Allowance;
use crate::findings::{Findings, ViolationKind};

struct Harm {
    kind: ViolationKind,
    allowance: Allowance,
    verb: &'static str,
    flag: fn(&ObjectTruth) -> u32,
}

const HARMS: [Harm; 4] = [
    Harm {
        kind: ViolationKind::ObjectCrushed,
        allowance: Allowance::CrushedObject,
        verb: "crushed",
        flag: |object| object.crushed,
    },
    Harm {
        kind: ViolationKind::ObjectDropped,
        allowance: Allowance::DroppedObject,
        verb: "dropped",
        flag: |object| object.dropped,
    },
    Harm {
        kind: ViolationKind::ObjectTipped,
        allowance: Allowance::TippedObject,
        verb: "tipped over",
        flag: |object| object.tipped,
    },
    Harm {
        kind: ViolationKind::ObjectSpilt,
        allowance: Allowance::SpiltObject,
        verb: "spilt",
        flag: |object| object.spilt,
    },
];

/// Returns the objects of the world.
pub(crate) fn objects(truth: &WorldTruth) -> &[ObjectTruth] {
    let count = (truth.object_count as usize).min(truth.objects.len());
    &truth.objects[..count]
}

/// Check of all objects; reports each harm of an object once.
#[derive(Clone, Debug, Default)]
pub(crate) struct ObjectCheck {
    epoch: u64,
    allowed: Vec<Allowance>,
    reported: Vec<(usize, ViolationKind)>,
}

impl ObjectCheck {
    pub(crate) fn allow(&mut self, allowance: Allowance) {
        self.allowed.push(allowance);
    }

    pub(crate) fn check(&mut self, truth: &WorldTruth, findings: &mut Findings) {
        // A restarted simulator has new objects.
        if truth.stamp.writer_epoch != self.epoch {
            self.epoch = truth.stamp.writer_epoch;
            self.reported.clear();
        }
        for (index, object) in objects(truth).iter().enumerate() {
            for harm in &HARMS {
                let is_new = !self.reported.contains(&(index, harm.kind));
                let is_allowed = self.allowed.contains(&harm.allowance);
                if (harm.flag)(object) != 0 && is_new && !is_allowed {
                    self.reported.push((index, harm.kind));
                    report(index, object, harm, findings);
                }
            }
        }
    }
}

fn report(index: usize, object: &ObjectTruth, harm: &Harm, findings: &mut Findings) {
    findings.report(
        harm.kind,
        format_args!(
            "object {index} ({}) {}: highest force {} N, crushed above {} N, tilt {} rad",
            object.name, harm.verb, object.max_force_n, object.crush_n, object.tilt_rad
        ),
    );
}
