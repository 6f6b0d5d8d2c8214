"""A Quoin law between atoms of LAMMPS, by `fix external`. The contact points of a rigid body are atoms; `fix rigid` sums
the forces on them to forces and moments of the body.

    lmp.command("fix law all external pf/callback 1 1")
    AtomJoints(material, atom_a, atom_b, normal, area, lmp).attach("law")

Atoms must keep their order: one process, `atom_modify sort 0 0`. Positions and forces are LAMMPS's arrays, without copies.
"""
import numpy as np

from joint_points import JointPoints, frames


class AtomJoints(JointPoints):
    """Contact points between atoms a and b, whose indices begin at 0; normals point from a to b."""

    def __init__(self, material, atom_a, atom_b, normal, area, lmp, initial_state=None):
        super().__init__(material, area, initial_state)
        self.atom_a, self.atom_b, self.lmp = atom_a, atom_b, lmp
        self.axes = frames(normal)
        self.ends = np.concatenate([atom_a, atom_b])
        self.reference = lmp.numpy.extract_atom("x")[:lmp.get_natoms()].copy()

    def attach(self, fix):
        self.lmp.set_fix_external_callback(fix, self.callback, None)

    def callback(self, _, step, atom_count, tag, x, f):
        f[:] = self.forces(x - self.reference)

    def forces(self, displacement):
        """Returns the force on every atom and updates the states by one step."""
        jump = displacement[self.atom_b] - displacement[self.atom_a]
        force = np.einsum("kn,nki->ni", self.forces_on_a(np.einsum("nki,ni->kn", self.axes, jump)), self.axes)
        parts = np.concatenate([force, -force])
        return np.stack([np.bincount(self.ends, column, len(displacement)) for column in parts.T], 1)
