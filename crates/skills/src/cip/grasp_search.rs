//! The domain of I_c: grasps from a point cloud that can be reached, held and shaken (thesis 3.2.1).

use factotum_descriptions::PlacementRange;
use factotum_geometry::Pose;
use factotum_motion::grasps::{PrincipalOptions, principal_grasps};
use rand_chacha::ChaCha8Rng;

use super::environment::{CipEnvironment, CipError};
use super::initiation::KnownGrasp;
use super::rig::{Placing, Rig};

/// Grasps that are generated, as in the thesis' code.
const N_GENERATED: usize = 50;

/// Tries to hold the object from a grasp before it is given up, each with the object elsewhere.
const N_TRIES: usize = 3;

/// How a search for grasps went.
#[derive(Debug, Clone, PartialEq)]
pub struct GraspSearch {
    /// Points of the cloud.
    pub n_points: usize,
    /// Grasps that the cloud suggested.
    pub n_generated: usize,
    /// Those that passed all checks.
    pub grasps: Vec<KnownGrasp>,
}

/// Searches grasps on what the cameras see of the object in the middle of its placements; `each` is told of every grasp
/// that was checked, and whether it is kept.
///
/// # Errors
/// [`CipError`] of the rig.
pub fn search_grasps<R: Rig>(
    environment: &mut CipEnvironment<R>,
    placement: &PlacementRange,
    rng: &mut ChaCha8Rng,
    each: &mut dyn FnMut(usize, bool),
) -> Result<GraspSearch, CipError<R::Error>> {
    let base_from_object = placement.at([0.5; 4]);
    let placing = Placing {
        base_from_object,
        object_joint: environment.success().start,
        q: environment.rig().anatomy().robot.q_ready(),
        opening: 1.0,
    };
    let rig = environment.rig_mut();
    rig.place(&placing).map_err(CipError::Rig)?;
    let cloud = rig.region_cloud().map_err(CipError::Rig)?;
    let options = PrincipalOptions {
        n_grasps: N_GENERATED,
        aperture_max_m: Some(rig.anatomy().aperture_max_m),
        centred: true,
        ..PrincipalOptions::default()
    };
    let generated = principal_grasps(&cloud, &options, rng);
    let object_from_base = base_from_object.inverse();
    let mut grasps = Vec::new();
    for (index, grasp) in generated.iter().enumerate() {
        let object_from_tcp: Pose = object_from_base * grasp.cloud_from_tcp;
        let mut kept = false;
        for _ in 0..N_TRIES {
            kept = environment.is_stable(&object_from_tcp, grasp.width_m, rng)?;
            if kept {
                break;
            }
        }
        if kept {
            grasps.push(KnownGrasp {
                object_from_tcp: object_from_tcp.into(),
                width_m: grasp.width_m,
                n_tries: 0,
                n_successes: 0,
            });
        }
        each(index, kept);
    }
    Ok(GraspSearch {
        n_points: cloud.len(),
        n_generated: generated.len(),
        grasps,
    })
}
