//! Mass matrix and Jacobian of an arm alone: the degrees of freedom that a controller has in its hands, out of a scene that
//! has many more. Where their numbers lie is found once, so that reading them at every step costs next to nothing.

use nalgebra::{DMatrix, Matrix6xX, Vector3};

use crate::ids::SiteId;
use crate::kinematics::row;
use crate::model::Model;
use crate::state::{State, view};

/// Some degrees of freedom, in an order of the caller's, and a site.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SiteChain {
    site: SiteId,
    dofs: Vec<usize>,
    /// The child of the world below which the site is.
    root: usize,
    /// Place in `dofs` of each that moves the site.
    moving: Vec<usize>,
    /// Entries of the mass matrix with their row and column.
    mass: Vec<MassEntry>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct MassEntry {
    adr: usize,
    row: usize,
    column: usize,
}

impl Model {
    /// The chain of these degrees of freedom that ends in `site`.
    pub fn site_chain(&self, site: SiteId, dofs: &[usize]) -> SiteChain {
        let tables = self.tables();
        let place = |dof: usize| dofs.iter().position(|&wanted| wanted == dof);
        let (mut root, mut moving) = (0, Vec::new());
        let mut body = self.site_body(site).0;
        while body != 0 {
            root = body;
            let joints = &tables.joints[tables.bodies[body].joints.clone()];
            let own = joints
                .iter()
                .flat_map(|joint| joint.dof_adr..joint.dof_adr + joint.kind.n_v());
            moving.extend(own.filter_map(place));
            body = tables.bodies[body].parent;
        }
        let mut mass = Vec::new();
        for (row, &dof) in dofs.iter().enumerate() {
            for adr in tables.mass_rows[dof].clone() {
                if let Some(column) = place(tables.mass_columns[adr]) {
                    mass.push(MassEntry { adr, row, column });
                }
            }
        }
        SiteChain {
            site,
            dofs: dofs.to_vec(),
            root,
            moving,
            mass,
        }
    }
}

impl SiteChain {
    /// The degrees of freedom.
    pub fn dofs(&self) -> &[usize] {
        &self.dofs
    }

    /// The site.
    pub fn site(&self) -> SiteId {
        self.site
    }
}

impl State {
    /// Rows and columns of the mass matrix that belong to a chain. `mass` is resized when it is of another size.
    pub fn chain_mass_into(&self, chain: &SiteChain, mass: &mut DMatrix<f64>) {
        let n = chain.dofs.len();
        if mass.shape() != (n, n) {
            *mass = DMatrix::zeros(n, n);
        }
        mass.fill(0.0);
        let entries = view!(self, M, self.model().tables().mass_columns.len());
        for &MassEntry { adr, row, column } in &chain.mass {
            mass[(row, column)] = entries[adr];
            mass[(column, row)] = entries[adr];
        }
    }

    /// Columns of the Jacobian of a chain's site that belong to it, as
    /// [`site_jacobian_into`](Self::site_jacobian_into).
    pub fn chain_jacobian_into(&self, chain: &SiteChain, jac: &mut Matrix6xX<f64>) {
        if jac.ncols() != chain.dofs.len() {
            *jac = Matrix6xX::zeros(chain.dofs.len());
        }
        jac.fill(0.0);
        let tables = self.model().tables();
        // MuJoCo refers motions to the centre of mass of the tree; rotation comes first.
        let centre: [f64; 3] = row(
            view!(self, subtree_com, 3 * tables.bodies.len()),
            chain.root,
        );
        let site: [f64; 3] = row(view!(self, site_xpos, 3 * tables.sites.len()), chain.site.0);
        let from_centre = Vector3::from(site) - Vector3::from(centre);
        let motions = view!(self, cdof, 6 * tables.n_v);
        for &column in &chain.moving {
            let [rx, ry, rz, x, y, z] = row(motions, chain.dofs[column]);
            let angular = Vector3::new(rx, ry, rz);
            let linear = Vector3::new(x, y, z) + angular.cross(&from_centre);
            jac.fixed_view_mut::<3, 1>(0, column).copy_from(&linear);
            jac.fixed_view_mut::<3, 1>(3, column).copy_from(&angular);
        }
    }
}
