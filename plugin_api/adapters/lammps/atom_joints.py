"""A Quoin law between atoms of LAMMPS, by `fix external`. Atoms of one rigid body are the places of its contact points;
`fix rigid` makes forces and moments of the forces on them.

    lmp.command("fix law all external pf/callback 1 1")
    AtomJoints(material, atom_a, atom_b, normal, area, lmp).attach("law")

Atoms keep their order: one process, `atom_modify sort 0 0`. Positions and forces are LAMMPS's own arrays.
"""
import numpy as np

from joint_points import JointPoints, frames


class AtomJoints(JointPoints):
    """Points from atom a to atom b, indices from 0."""

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
        """On every atom; the states go one step on."""
        jump = displacement[self.atom_b] - displacement[self.atom_a]
        force = np.einsum("kn,nki->ni", self.forces_on_a(np.einsum("nki,ni->kn", self.axes, jump)), self.axes)
        parts = np.concatenate([force, -force])
        return np.stack([np.bincount(self.ends, column, len(displacement)) for column in parts.T], 1)
