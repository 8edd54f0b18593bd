//! What changes in a world, written to bytes and read back exactly.
//!
//! One description of the state ([`visit`]) serves both directions, so they cannot disagree. Numbers are little-endian;
//! floats keep every bit. Motions under way are not stored: a world is stored between motions.

use std::collections::BTreeMap;

use factotum_control::gripper::GripperController;
use factotum_control::wrench_estimate::WrenchEstimate;
use factotum_control::{MotionId, MotionStatus, Stamped};
use factotum_geometry::Pose2;
use factotum_geometry::sensing::LaserScan;
use nalgebra::{Complex, DVector, UnitComplex};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

use super::Live;

/// Begins every stored world; the digit is the version of the format.
const MAGIC: u64 = u64::from_le_bytes(*b"FCTWRLD1");

/// Longest list or text that is believed, entries.
const LEN_MAX: u64 = 1 << 28;

/// Why bytes are no world, or a world cannot be stored.
pub(crate) type Problem = String;

/// Writes a value, or replaces it by the one read.
pub(crate) trait Codec {
    fn u64(&mut self, value: &mut u64) -> Result<(), Problem>;

    fn f64(&mut self, value: &mut f64) -> Result<(), Problem> {
        let mut bits = value.to_bits();
        self.u64(&mut bits)?;
        *value = f64::from_bits(bits);
        Ok(())
    }

    fn bool(&mut self, value: &mut bool) -> Result<(), Problem> {
        let mut bits = u64::from(*value);
        self.u64(&mut bits)?;
        *value = bits != 0;
        Ok(())
    }

    fn len(&mut self, len: usize) -> Result<usize, Problem> {
        let mut n = len as u64;
        self.u64(&mut n)?;
        if n > LEN_MAX {
            return Err(format!("a list of {n} entries"));
        }
        Ok(n as usize)
    }

    fn f64s(&mut self, values: &mut Vec<f64>) -> Result<(), Problem> {
        let n = self.len(values.len())?;
        values.resize(n, 0.0);
        values.iter_mut().try_for_each(|value| self.f64(value))
    }

    fn text(&mut self, value: &mut String) -> Result<(), Problem> {
        let mut bytes: Vec<f64> = value.bytes().map(f64::from).collect();
        self.f64s(&mut bytes)?;
        let bytes = bytes.into_iter().map(|byte| byte as u8).collect();
        *value = String::from_utf8(bytes).map_err(|error| error.to_string())?;
        Ok(())
    }
}

/// Writes.
#[derive(Debug, Default)]
pub(crate) struct Writer(pub(crate) Vec<u8>);

impl Codec for Writer {
    fn u64(&mut self, value: &mut u64) -> Result<(), Problem> {
        self.0.extend_from_slice(&value.to_le_bytes());
        Ok(())
    }
}

/// Reads.
#[derive(Debug)]
pub(crate) struct Reader<'a>(pub(crate) &'a [u8]);

impl Codec for Reader<'_> {
    fn u64(&mut self, value: &mut u64) -> Result<(), Problem> {
        let Some((bytes, rest)) = self.0.split_first_chunk::<8>() else {
            return Err("the bytes end too early".to_owned());
        };
        *value = u64::from_le_bytes(*bytes);
        self.0 = rest;
        Ok(())
    }
}

/// Visits the whole world: numbers of physics, then `live`.
pub(crate) fn visit(
    codec: &mut impl Codec,
    physics: &mut Vec<f64>,
    live: &mut Live,
) -> Result<(), Problem> {
    let mut magic = MAGIC;
    codec.u64(&mut magic)?;
    if magic != MAGIC {
        return Err("the bytes do not begin as a stored world of this version does".to_owned());
    }
    codec.f64s(physics)?;
    codec.u64(&mut live.next_id)?;
    statuses(codec, &mut live.statuses)?;
    arm(codec, live)?;
    codec.f64(&mut live.lift.target_m)?;
    codec.f64(&mut live.lift.correction_m)?;
    if let Some(base) = &mut live.base {
        base.motion = None;
        base.command
            .iter_mut()
            .try_for_each(|value| codec.f64(value))?;
    }
    if let Some(grip) = &mut live.grip {
        grip.motion = None;
        gripper(codec, &mut grip.controller)?;
    }
    let odometry = &mut live.odometry;
    pose(codec, &mut odometry.odom_from_base)?;
    pose(codec, &mut odometry.true_before)?;
    for value in [
        &mut odometry.scale,
        &mut odometry.turn_scale,
        &mut odometry.walk_m,
        &mut odometry.walk_rad,
    ] {
        codec.f64(value)?;
    }
    rng(codec, &mut odometry.rng)?;
    rng(codec, &mut live.lidar_rng)?;
    rng(codec, &mut live.camera_rng)?;
    last_scan(codec, &mut live.last_scan)?;
    let fault = &mut live.fault;
    option(codec, &mut fault.happened, String::new(), |codec, text| {
        codec.text(text)
    })?;
    codec.f64(&mut fault.carried_secs)?;
    option(codec, &mut fault.slips_until_secs, 0.0, |codec, secs| {
        codec.f64(secs)
    })?;
    rng(codec, &mut fault.rng)?;
    codec.f64(&mut live.remainder_secs)?;
    codec.f64s(&mut live.pad_forces_n)?;
    codec.bool(&mut live.carrying)?;
    codec.bool(&mut live.touching)?;
    codec.f64(&mut live.observed_secs)
}

fn option<C: Codec, T>(
    codec: &mut C,
    value: &mut Option<T>,
    empty: T,
    visit: impl FnOnce(&mut C, &mut T) -> Result<(), Problem>,
) -> Result<(), Problem> {
    let mut present = value.is_some();
    codec.bool(&mut present)?;
    if present {
        visit(codec, value.get_or_insert(empty))
    } else {
        *value = None;
        Ok(())
    }
}

fn statuses(
    codec: &mut impl Codec,
    statuses: &mut BTreeMap<MotionId, MotionStatus>,
) -> Result<(), Problem> {
    let n = codec.len(statuses.len())?;
    let mut entries: Vec<(MotionId, MotionStatus)> = std::mem::take(statuses).into_iter().collect();
    entries.resize(n, (MotionId(0), MotionStatus::Done));
    for (id, status) in &mut entries {
        codec.u64(&mut id.0)?;
        let (mut kind, mut reason) = match status {
            MotionStatus::Active => {
                return Err(format!(
                    "motion {} is under way; wait for it or stop it",
                    id.0
                ));
            }
            MotionStatus::Done => (0, String::new()),
            MotionStatus::Guarded => (1, String::new()),
            MotionStatus::Preempted => (2, String::new()),
            MotionStatus::Aborted(reason) => (3, std::mem::take(reason)),
        };
        codec.u64(&mut kind)?;
        codec.text(&mut reason)?;
        *status = match kind {
            0 => MotionStatus::Done,
            1 => MotionStatus::Guarded,
            2 => MotionStatus::Preempted,
            3 => MotionStatus::Aborted(reason),
            other => return Err(format!("motion status {other}, expected 0 to 3")),
        };
    }
    statuses.extend(entries);
    Ok(())
}

fn arm(codec: &mut impl Codec, live: &mut Live) -> Result<(), Problem> {
    let arm = &mut live.arm;
    arm.motion = None;
    vector(codec, &mut arm.hold)?;
    let mut integral = arm.tracker.integral().clone();
    vector(codec, &mut integral)?;
    let mut last = arm.limiter.last().clone();
    vector(codec, &mut last)?;
    arm.tracker
        .set_integral(integral.as_slice())
        .and_then(|()| arm.limiter.set_last(&last))
        .map_err(|error| error.to_string())?;
    let (external, before) = arm.wrench.memory();
    let (mut external, mut before) = (external.clone(), before.cloned());
    vector(codec, &mut external)?;
    let empty = DVector::zeros(external.len());
    option(codec, &mut before, empty, |codec, values| {
        vector(codec, values)
    })?;
    arm.wrench = WrenchEstimate::from_memory(external, before);
    Ok(())
}

fn gripper(codec: &mut impl Codec, controller: &mut GripperController) -> Result<(), Problem> {
    for value in [
        &mut controller.goal.opening,
        &mut controller.goal.force_n,
        &mut controller.target,
        &mut controller.stopped_secs,
        &mut controller.opening_before,
    ] {
        codec.f64(value)?;
    }
    Ok(())
}

/// A vector keeps its length: another one is another robot's.
fn vector(codec: &mut impl Codec, values: &mut DVector<f64>) -> Result<(), Problem> {
    let n = codec.len(values.len())?;
    if n != values.len() {
        return Err(format!("{n} joints, expected {}", values.len()));
    }
    values.iter_mut().try_for_each(|value| codec.f64(value))
}

fn pose(codec: &mut impl Codec, pose: &mut Pose2) -> Result<(), Problem> {
    codec.f64(&mut pose.translation.x)?;
    codec.f64(&mut pose.translation.y)?;
    let (mut re, mut im) = (pose.rotation.re, pose.rotation.im);
    codec.f64(&mut re)?;
    codec.f64(&mut im)?;
    // Not normalised again: the bits must stay.
    pose.rotation = UnitComplex::new_unchecked(Complex::new(re, im));
    Ok(())
}

fn rng(codec: &mut impl Codec, rng: &mut ChaCha8Rng) -> Result<(), Problem> {
    let mut seed = rng.get_seed();
    for chunk in seed.chunks_exact_mut(8) {
        let mut bytes = [0; 8];
        bytes.copy_from_slice(chunk);
        let mut value = u64::from_le_bytes(bytes);
        codec.u64(&mut value)?;
        chunk.copy_from_slice(&value.to_le_bytes());
    }
    let mut stream = rng.get_stream();
    codec.u64(&mut stream)?;
    let place = rng.get_word_pos();
    let (mut low, mut high) = (place as u64, (place >> 64) as u64);
    codec.u64(&mut low)?;
    codec.u64(&mut high)?;
    *rng = ChaCha8Rng::from_seed(seed);
    rng.set_stream(stream);
    rng.set_word_pos(u128::from(low) | (u128::from(high) << 64));
    Ok(())
}

fn last_scan(codec: &mut impl Codec, scan: &mut Option<Stamped<LaserScan>>) -> Result<(), Problem> {
    let empty = Stamped {
        time_secs: 0.0,
        odom_from_base: Pose2::identity(),
        data: LaserScan {
            angle_min_rad: 0.0,
            angle_step_rad: 0.0,
            ranges_m: Vec::new(),
            range_min_m: 0.0,
            range_max_m: 0.0,
            base_from_lidar: Pose2::identity(),
        },
    };
    option(codec, scan, empty, |codec, stamped| {
        codec.f64(&mut stamped.time_secs)?;
        pose(codec, &mut stamped.odom_from_base)?;
        let data = &mut stamped.data;
        for value in [
            &mut data.angle_min_rad,
            &mut data.angle_step_rad,
            &mut data.range_min_m,
            &mut data.range_max_m,
        ] {
            codec.f64(value)?;
        }
        codec.f64s(&mut data.ranges_m)?;
        pose(codec, &mut data.base_from_lidar)
    })
}
