//! Schema catalogue: every payload and code of the bus, as data.
//!
//! It is the source of the C header (`atas.h`), the tables of the protocol page and the Python
//! array types, which therefore match the compiled layout.

use crate::schema::{CodeType, PayloadType};
use crate::{arena, base, cause, control, event, frame, goal, joints, module, reason_record};
use crate::{record, sensor_bit, stamp, status, stop, swarm, target, tick, truth, view};

/// Every code.
pub const CODES: &[&CodeType] = &[
    &stamp::Hand::CODE,
    &joints::Mode::CODE,
    &goal::GoalKind::CODE,
    &goal::GoalPolicy::CODE,
    &goal::GoalState::CODE,
    &goal::Turn::CODE,
    &target::GripOrder::CODE,
    &control::ControlOp::CODE,
    &control::ControlOutcome::CODE,
    &stop::StopOutcome::CODE,
    &event::EventKind::CODE,
    &module::ModuleId::CODE,
    &cause::Cause::CODE,
    &record::OrderKind::CODE,
    &sensor_bit::SensorBit::CODE,
    &base::Light::CODE,
    &base::ControlOwner::CODE,
    &base::Mishap::CODE,
];

/// Every payload; nested payloads come before those that contain them.
pub const PAYLOADS: &[&PayloadType] = &[
    &stamp::Stamp::PAYLOAD,
    &frame::HandFrame::PAYLOAD,
    &joints::JointState::PAYLOAD,
    &joints::JointCommand::PAYLOAD,
    &goal::GoalRequest::PAYLOAD,
    &goal::GraspFigures::PAYLOAD,
    &reason_record::ReasonRecord::PAYLOAD,
    &goal::GoalUpdate::PAYLOAD,
    &target::GraspTarget::PAYLOAD,
    &control::ControlRequest::PAYLOAD,
    &control::ControlReply::PAYLOAD,
    &stop::StopRequest::PAYLOAD,
    &stop::StopAnswer::PAYLOAD,
    &event::ModuleEvent::PAYLOAD,
    &status::Percentiles::PAYLOAD,
    &status::HandStatus::PAYLOAD,
    &status::JointStatus::PAYLOAD,
    &status::Status::PAYLOAD,
    &status::SensorStatus::PAYLOAD,
    &tick::FingerReport::PAYLOAD,
    &tick::HandReport::PAYLOAD,
    &tick::TickReport::PAYLOAD,
    &view::View::PAYLOAD,
    &record::SettingsRecord::PAYLOAD,
    &record::StepRecord::PAYLOAD,
    &record::TrackRecord::PAYLOAD,
    &record::TableRecord::PAYLOAD,
    &record::TaskRecord::PAYLOAD,
    &record::OrderRecord::PAYLOAD,
    &record::TickInputs::PAYLOAD,
    &record::HandWiringRecord::PAYLOAD,
    &record::RunHeader::PAYLOAD,
    &swarm::AgentSensors::PAYLOAD,
    &swarm::WheelCommands::PAYLOAD,
    &base::BaseState::PAYLOAD,
    &base::BaseCommand::PAYLOAD,
    &truth::ObjectTruth::PAYLOAD,
    &truth::WorldTruth::PAYLOAD,
    &arena::AgentTruth::PAYLOAD,
    &arena::FieldTruth::PAYLOAD,
    &arena::TrialTruth::PAYLOAD,
    &arena::WallTruth::PAYLOAD,
    &arena::PostTruth::PAYLOAD,
    &arena::ArenaTruth::PAYLOAD,
];
