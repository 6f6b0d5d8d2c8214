"""A wall of n x n bodies with Yade's contact laws:  yade -n -x native.py N spheres|polyhedra STEPS

Prints bodies, contacts and processor time of a step in microseconds. Spheres: bonded by the concrete particle model
(CPM), one point for each contact. Polyhedra: cubes without bonds, with an overlap of 1e-4 of their size.
"""
import sys
import time

from yade import *

EDGE, DENSITY = 0.1, 1900.0


def spheres(n):
    material = O.materials.append(CpmMat(young=4e9, poisson=0.2, density=DENSITY, frictionAngle=0.6, sigmaT=0.2e6,
                                         epsCrackOnset=5e-5, relDuctility=30))
    rows = [[O.bodies.append(sphere((x * EDGE, y * EDGE, 0), EDGE / 2, material=material)) for x in range(n)]
            for y in range(n)]
    near = 1.02  # bonds with neighbours, not across the diagonal
    bounds, touch = Bo1_Sphere_Aabb(aabbEnlargeFactor=near), Ig2_Sphere_Sphere_ScGeom(interactionDetectionFactor=near)
    return rows, 1e-5, bounds, InteractionLoop([touch], [Ip2_CpmMat_CpmMat_CpmPhys()], [Law2_ScGeom_CpmPhys_Cpm()])


def polyhedra(n):
    from yade import polyhedra_utils
    material = PolyhedraMat()
    material.density, material.young, material.poisson, material.frictionAngle = DENSITY, 4e9, 2e9, 0.6
    half = EDGE / 2 * (1 + 1e-4)
    corners = [Vector3(x, y, z) * half for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]

    def add(x, y):
        body = polyhedra_utils.polyhedra(material, v=corners)
        body.state.pos = (x * EDGE, y * EDGE, 0)
        return O.bodies.append(body)

    rows = [[add(x, y) for x in range(n)] for y in range(n)]
    return rows, 1e-6, Bo1_Polyhedra_Aabb(), InteractionLoop(
        [Ig2_Polyhedra_Polyhedra_PolyhedraGeom()], [Ip2_PolyhedraMat_PolyhedraMat_PolyhedraPhys()],
        [Law2_PolyhedraGeom_PolyhedraPhys_Volumetric()])


n, steps = int(sys.argv[1]), int(sys.argv[3])
rows, O.dt, bounds, contacts = {"spheres": spheres, "polyhedra": polyhedra}[sys.argv[2]](n)
for i in rows[0] + rows[-1]:
    O.bodies[i].state.blockedDOFs = "xyzXYZ"
for i in rows[-1]:
    O.bodies[i].state.vel = (0.01, 0, 0)
O.engines = [ForceResetter(), InsertionSortCollider([bounds]), contacts, NewtonIntegrator(damping=0.8)]
O.run(20, True)  # detects the contacts
start = time.process_time()
O.run(steps, True)
seconds = time.process_time() - start
print("native", len(O.bodies), O.interactions.countReal(), seconds / steps * 1e6)
