"""Geometry of other programs: assemblies of COMPAS, meshes of gmsh. The tests write files in the published layouts of
compas_assembly and compas_dem; gmsh writes its files where it is installed."""
import json
import os
import unittest

import numpy as np
import quoin
from shapes_test import scene_of
from support import SMALL_WALL, Folder


def mesh_of(x, y, z, **attributes):
    """Returns a unit cube as a mesh of COMPAS."""
    corners = [(i & 1, i >> 1 & 1, i >> 2) for i in range(8)]
    return {"attributes": attributes, "dva": {"x": 0.0, "y": 0.0, "z": 0.0}, "dea": {}, "dfa": {},
            "vertex": {str(i): {"x": x + a, "y": y + b, "z": z + c} for i, (a, b, c) in enumerate(corners)},
            "face": {"0": [0, 4, 6, 2], "1": [1, 3, 7, 5], "2": [0, 1, 5, 4], "3": [2, 6, 7, 3], "4": [0, 2, 3, 1],
                     "5": [4, 5, 7, 6]},
            "facedata": {}, "edgedata": {}, "max_vertex": 7, "max_face": 5}


def compas_1(blocks):
    """compas_assembly with COMPAS 1: dtype and value; supports are attributes of the nodes of the graph."""
    nodes = {str(i): {"x": 0, "y": 0, "z": 0, "is_support": support,
                      "block": {"dtype": "compas_assembly.datastructures/Block", "value": mesh}}
             for i, (mesh, support) in enumerate(blocks)}
    edges = {"0": {"1": {"interface": {"dtype": "compas_assembly.datastructures/Interface", "value": {
        "mesh": {"dtype": "compas.datastructures/Mesh", "value": mesh_of(9, 9, 9)}}}}}}
    return {"compas": "1.17.5", "dtype": "compas_assembly.datastructures/Assembly", "value": {
        "attributes": {"name": "Assembly"}, "graph": {"attributes": {"name": "Graph"}, "node": nodes, "edge": edges,
                                                      "adjacency": {}, "max_node": len(nodes) - 1}}}


def compas_2(blocks):
    """compas_dem with COMPAS 2: dtype and data; a model's elements, placed by transformations, z up."""
    elements = [{"dtype": "compas_dem.elements/BlockElement", "name": f"stone {i}", "data": {
        "geometry": {"dtype": "compas.datastructures/Mesh", "data": mesh_of(0, 0, 0)},
        "transformation": {"dtype": "compas.geometry/Transformation", "data": {
            "matrix": [[1, 0, 0, at[0]], [0, 1, 0, at[1]], [0, 0, 1, at[2]], [0, 0, 0, 1]]}},
        "is_support": support}} for i, (at, support) in enumerate(blocks)]
    return {"dtype": "compas_dem.models/BlockModel", "data": {"tree": {"name": "root"}, "graph": {"node": {}},
                                                              "elements": elements}, "guid": "x"}


def before_compas_1(blocks):
    """compas_assembly before COMPAS 1: blocks beside the graph, which has the supports; all have the name Block."""
    return {"assembly": {"attributes": {"name": "Assembly"}, "node_attributes": {"is_support": False}, "edge": {},
                         "node": {str(i): {"x": 0, **({"is_support": True} if s else {})} for i, (_, s) in enumerate(blocks)}},
            "blocks": {str(i): mesh for i, (mesh, _) in enumerate(blocks)}}


class Compas(Folder):
    def setUp(self):
        super().setUp()
        self.floor, self.cube = mesh_of(0, 0, 0, name="Block"), mesh_of(0, 0, 1, name="Block")

    def scene(self, data, **keys):
        with open(self.path("assembly.json"), "w", encoding="utf-8") as file:
            json.dump(data, file)
        return scene_of([quoin.Block(name="a", material="stone", mesh=self.path("assembly.json"), **keys)],
                        gravity=[0, 0, -9.81])

    def assert_stands_on_its_support(self, scene):
        sim = quoin.Simulation(scene)
        self.assertEqual(sim.blocks, 2)
        sim.run()
        # 1 m3 of 2000 kg/m3 weighs 19620 N on the joint's 1 m2. Tolerance 1 %, for remaining vibration.
        self.assertAlmostEqual(np.sum(sim.sigma("dry") * sim.area("dry")), -19620.0, delta=200.0)
        self.assertLess(sim.history["largest_displacement_m"].max(), 1e-4)

    def test_an_assembly_of_compas_1_stands(self):
        self.assert_stands_on_its_support(self.scene(compas_1([(mesh_of(0, 0, 0), True), (mesh_of(0, 0, 1), False)])))

    def test_a_model_of_compas_dem_stands(self):
        self.assert_stands_on_its_support(self.scene(compas_2([((0, 0, 0), True), ((0, 0, 1), False)])))

    def test_it_is_drawn_and_named(self):
        scene = self.scene(compas_2([((0, 0, 0), True), ((0, 0, 1), False)]))
        scene.output.frames, scene.output.frames_of = 2, "last"
        scene.stage[0].duration = 0.05
        scene.write(self.path("scene.toml"))
        done = self.command("run", "scene.toml", "--out", "out")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.command("report", "out").returncode, 0)
        sim = quoin.Simulation(scene)
        self.assertEqual(sim.velocity("a/stone 1").shape, (1, 3))

    def test_old_files_have_their_supports_in_the_graph(self):
        scene = self.scene(before_compas_1([(self.floor, True), (self.cube, False)]))
        self.assert_stands_on_its_support(scene)
        sim = quoin.Simulation(scene)
        self.assertEqual(sim.velocity("a/Block#1").shape, (1, 3))

    def test_a_support_may_be_one_face(self):
        self.floor["vertex"] = {k: dict(v, z=1.0) for k, v in self.floor["vertex"].items() if int(k) < 4}
        self.floor["face"] = {"0": [0, 1, 3, 2]}
        self.assert_stands_on_its_support(self.scene(before_compas_1([(self.floor, True), (self.cube, False)])))
        with self.assertRaisesRegex(quoin.BadInput, "Block#0: is drawn as a flat face"):
            quoin.Simulation(self.scene(before_compas_1([(self.floor, False), (self.cube, False)])))
        self.assert_stands_on_its_support(self.scene(before_compas_1([(self.floor, False), (self.cube, False)]),
                                                     fixed=["Block#0"]))

    def test_warped_faces_are_one_joint(self):
        """Both blocks have common corners, one of them raised by 1 mm: a joint of 1 m2."""
        self.floor["vertex"]["7"]["z"] = self.cube["vertex"]["3"]["z"] = 1.001
        scene = self.scene(compas_1([(self.floor, True), (self.cube, False)]))
        self.assert_stands_on_its_support(scene)
        sim = quoin.Simulation(scene)
        self.assertAlmostEqual(np.sum(sim.area("dry")), 1.0, delta=1e-3)
        scene.stage[0].duration = 0.01
        scene.write(self.path("scene.toml"))
        words = "2 of 2 blocks have faces that no plane fits, and were made planar: their surfaces moved by 0.00025 m at most"
        self.assertIn(words, self.command("check", "scene.toml").stdout)
        done = self.command("run", "scene.toml", "--out", "out")
        self.assertIn(words, done.stdout + done.stderr)

    def test_what_is_wrong_is_told_with_its_place(self):
        broken = mesh_of(0, 0, 1)
        broken["face"]["3"] = [2, 6, 77, 3]
        lame = mesh_of(0, 0, 1)
        del lame["vertex"]["5"]["y"]
        deep = {}
        for _ in range(100):
            deep = {"value": deep}
        for data, words in ((compas_1([(broken, False)]), "face 3 has a vertex 77 that is not there"),
                            (compas_1([(lame, False)]), "value.graph.node.0.block.value: vertex 5 has no number y"),
                            ({"dtype": "nothing"}, "no block in this file"), (deep, "nested too deep")):
            with self.assertRaisesRegex(quoin.BadInput, words):
                quoin.Simulation(self.scene(data))
        with open(self.path("rubbish.json"), "w", encoding="utf-8") as file:
            file.write('{"dtype": ')
        scene = self.scene({})
        scene.block[0].mesh = self.path("rubbish.json")
        with self.assertRaisesRegex(quoin.BadInput, "rubbish.json: not valid JSON"):
            quoin.Simulation(scene)


class Obj(Folder):
    """OBJ files as Blender and Rhino write them: normals, texture coordinates, objects with names."""

    def write(self, corner):
        """Writes a slab and a post on it. corner: format of a face's corner, with {0} for the number."""
        text = "mtllib none.mtl\nvn 0 0 1\nvt 0.5 0.5\n"
        for name, (x, y, z), size in (("foundation", (-0.5, -0.2, -0.5), (2, 0.2, 2)), ("post 1", (0, 0, 0), (1, 1, 1))):
            text += f"o {name}\n" + "".join(f"v {x + size[0] * (i & 1)} {y + size[1] * (i >> 1 & 1)} {z + size[2] * (i >> 2)}\n"
                                           for i in range(8)) + "vn 0 1 0\nusemtl stone\ns off\n"
            for face in ((0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)):
                text += "f " + " ".join(corner.format(i - 8) for i in face) + "\n"
        with open(self.path("two.obj"), "w", encoding="utf-8") as file:
            file.write(text)
        return self.path("two.obj")

    def assert_stands(self, blocks):
        sim = quoin.Simulation(scene_of(blocks))
        sim.run()
        self.assertAlmostEqual(np.sum(sim.sigma("dry") * sim.area("dry")), -19620.0, delta=200.0)

    def test_normals_are_passed_over_and_names_kept(self):
        for corner in ("{0}", "{0}//1", "{0}/1/1", "{0}/1"):
            with self.subTest(corner):
                blocks = quoin.read_blocks(self.write(corner), material="stone", fixed=["foundation"])
                self.assertEqual([b.name for b in blocks], ["foundation", "post 1"])
                self.assertEqual(["fixed" in b for b in blocks], [True, False])
                self.assert_stands(blocks)
        named = quoin.read_blocks(self.write("{0}//1"), material="stone", name="site", scale=2.0, fixed=["site/foundation"])
        self.assertEqual([b.name for b in named], ["site/foundation", "site/post 1"])
        self.assertTrue(named[0].fixed)
        self.assertEqual(np.max(named[1].vertices), 2.0)
        os.rename(self.write("{0}"), self.path("TWO.OBJ"))
        capitals = quoin.read_blocks(self.path("TWO.OBJ"), material="stone", fixed=["foundation"])
        self.assertEqual([b.name for b in capitals], ["foundation", "post 1"])
        with self.assertRaisesRegex(quoin.BadInput, "no block is called 'fundation'; did you mean 'foundation'"):
            quoin.read_blocks(self.write("{0}"), material="stone", fixed=["fundation"])
        with self.assertRaisesRegex(quoin.BadInput, "give zone_edge"):
            quoin.read_blocks(self.write("{0}"), material="stone", rigid=False)

    def test_a_block_of_a_mesh_is_fixed_by_name(self):
        self.write("{0}//1")
        for name, fixed in (("site", ["foundation"]), ("site", ["site/foundation"]), (None, ["foundation"])):
            block = quoin.Block(material="stone", mesh=self.path("two.obj"), fixed=fixed)
            if name:
                block.name = name
            self.assert_stands([block])
            scene = scene_of([block], duration=0.01)
            scene.write(self.path("scene.toml"))
            self.assertEqual(quoin.Scene.load(self.path("scene.toml")), scene)
            self.assertEqual(self.command("run", "scene.toml", "--out", "out").returncode, 0)
        for fixed, words in ((["fundation"], "fixed: no block of .*two.obj is called 'fundation'.*foundation"),
                             ([], "fixed.*a list of names"), ([3], "fixed.*a list of names"), ("all", "fixed.*true or false")):
            with self.assertRaisesRegex(quoin.BadInput, words):
                quoin.Simulation(scene_of([quoin.Block(material="stone", mesh=self.path("two.obj"), fixed=fixed)]))
        with self.assertRaisesRegex(quoin.BadInput, "fixed.*of a mesh"):
            quoin.Simulation(scene_of([quoin.Block(material="stone", box=dict(size=[1, 1, 1]), fixed=["a"])]))


def mesh_boxes(test, name, boxes, edge, version=4.1):
    """Meshes boxes (corner, then size; m) separately with gmsh into a file of the test's folder. Returns the number of
    tetrahedra."""
    try:
        import gmsh
    except ImportError:
        test.skipTest("gmsh is not installed (python3-gmsh)")
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        for box in boxes:
            gmsh.model.occ.addBox(*box)
        gmsh.model.occ.synchronize()
        gmsh.option.setNumber("Mesh.MeshSizeMax", edge)
        gmsh.model.mesh.generate(3)
        gmsh.write(test.path(name))
        return len(gmsh.model.mesh.getElementsByType(4)[0])
    finally:
        gmsh.finalize()


class Gmsh(Folder):
    def setUp(self):
        super().setUp()
        try:
            import meshio  # noqa: F401
        except ImportError:
            self.skipTest("meshio is not installed (python3-meshio)")

    def mesh(self, version):
        """Writes a slab and a cube on it, meshed separately by gmsh."""
        mesh_boxes(self, "two.msh", [(-0.5, -0.2, -0.5, 2, 0.2, 2), (0, 0, 0, 1, 1, 1)], 0.5, version)
        return self.path("two.msh")

    def test_bodies_of_tetrahedra_are_blocks_that_stand(self):
        for version in (2.2, 4.1):
            with self.subTest(version):
                blocks = quoin.read_blocks(self.mesh(version), material="stone")
                self.assertEqual(len(blocks), 2)
                blocks[0].fixed = True
                sim = quoin.Simulation(scene_of(blocks))
                sim.run()
                # 1 m3 of 2000 kg/m3 weighs 19620 N. Tolerance 1 %, for remaining vibration.
                self.assertAlmostEqual(np.sum(sim.sigma("dry") * sim.area("dry")), -19620.0, delta=200.0)
        blocks = quoin.read_blocks(self.mesh(4.1), material="stone", rigid=False, zone_edge=0.5)
        self.assertGreater(quoin.Simulation(scene_of(blocks)).zones, 10)

    def test_surfaces_are_rigid_blocks(self):
        with open(self.path("cube.ply"), "w", encoding="utf-8") as file:
            file.write("ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
                       "element face 6\nproperty list uchar int vertex_indices\nend_header\n" +
                       "".join(f"{i & 1} {i >> 1 & 1} {i >> 2}\n" for i in range(8)) +
                       "4 0 4 6 2\n4 1 3 7 5\n4 0 1 5 4\n4 2 6 7 3\n4 0 2 3 1\n4 4 5 7 6\n")
        blocks = quoin.read_blocks(self.path("cube.ply"), material="stone", scale=0.5)
        self.assertEqual(len(blocks), 1)
        self.assertEqual(np.max(blocks[0].vertices), 0.5)
        self.assertEqual(quoin.Simulation(scene_of(blocks)).blocks, 1)

    def test_what_is_no_mesh_is_refused(self):
        with open(self.path("rubbish.msh"), "w", encoding="utf-8") as file:
            file.write("$MeshFormat\n9 9 9\n")
        with self.assertRaisesRegex(quoin.BadInput, "rubbish.msh: meshio cannot read it"):
            quoin.read_blocks(self.path("rubbish.msh"), material="stone")
        with self.assertRaisesRegex(quoin.BadInput, "nowhere.msh: cannot read it: no such file"):
            quoin.read_blocks(self.path("nowhere.msh"), material="stone")

    def test_what_readers_let_pass_is_refused(self):
        """Invalid indices and counts cause neither an endless loop nor IndexError; -1 is not the last point."""
        head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n"
        faces = "element face 1\nproperty list uint8 int32 vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n"
        many = "element face 12000000000\nend_header\n0 0 0\n"
        for text, words in ((head, "its header has no end"), (head + many, "tells of 12000000000 elements"),
                            (head + faces + "3 0 1 3\n", "has the point 3, and there are 3"),
                            (head + faces + "3 0 1 -1\n", "has the point -1"), (head + faces + "0\n", "has 0 corners")):
            with self.subTest(words):
                with open(self.path("bad.ply"), "w", encoding="utf-8") as file:
                    file.write(text)
                with self.assertRaisesRegex(quoin.BadInput, "bad.ply: .*" + words):
                    quoin.read_blocks(self.path("bad.ply"), material="stone")


def column_of_tetrahedra(width, height, across, along, seed=1):
    """Returns points and tetrahedra of a column along y: a grid of boxes of six tetrahedra, with randomly moved inner
    gridpoints, so that the zones differ from those of make_zones."""
    counts = np.array([across, along, across])
    grid = np.array(list(np.ndindex(*(counts + 1))), dtype=float)
    inner = ((grid > 0) & (grid < counts)).all(axis=1)
    grid[inner] += np.random.RandomState(seed).uniform(-0.2, 0.2, (inner.sum(), 3))
    points = grid / counts * [width, height, width]

    def number(corner):
        return (corner[0] * (along + 1) + corner[1]) * (across + 1) + corner[2]
    tetrahedra = []
    for low in np.ndindex(*counts):
        for order in ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)):
            corner, path = np.array(low), [number(low)]
            for axis in order:
                corner = corner + np.eye(3, dtype=int)[axis]
                path.append(number(corner))
            even = order in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
            tetrahedra.append(path if even else [path[i] for i in (0, 2, 1, 3)])  # of positive volume
    return points, tetrahedra


class Tetrahedra(Folder):
    """The zones of the user's mesh."""

    WIDTH, HEIGHT, MODULUS, DENSITY, STIFFNESS = 0.5, 2.0, 1e8, 2000.0, 1e10

    def setUp(self):
        super().setUp()
        try:
            import meshio
        except ImportError:
            self.skipTest("meshio is not installed (python3-meshio)")
        self.meshio = meshio

    def column(self, blocks):
        """Runs blocks on a fixed base under their weight. With Poisson's ratio 0 and a joint of low shear stiffness the stress
        is uniaxial."""
        scene = scene_of([quoin.Block(name="base", material="stone", fixed=True,
                                      box=dict(lower=[-0.5, -0.2, -0.5], size=[1.5, 0.2, 1.5])), *blocks], duration=0.6)
        scene.materials.stone = quoin.BlockMaterial(density=self.DENSITY, young_modulus=self.MODULUS, poisson_ratio=0.0)
        scene.joints.dry = quoin.Joint(law="elastic", normal_stiffness=self.STIFFNESS, shear_stiffness=1.0)
        return scene

    def assert_sinks_by_its_weight(self, blocks, zones):
        sim = quoin.Simulation(self.column(blocks))
        self.assertEqual(sim.zones, zones)
        sim.run()
        weight = self.DENSITY * 9.81 * self.HEIGHT  # Pa
        self.assertAlmostEqual(np.sum(sim.sigma("dry") * sim.area("dry")), -weight * self.WIDTH**2,
                               delta=2e-3 * weight * self.WIDTH**2)  # tolerance for remaining motion
        mesh = sim.mesh()
        own = mesh["points"][mesh["block"] == 1]
        top = np.isclose(own[:, 1], self.HEIGHT)
        sinks = -np.array(sim.displacement(1))[top, 1].mean()
        # rho g h^2 / 2E, plus the joint. Measured: 4e-4 more with 540 zones, 3e-4 with 1536.
        expected = weight * self.HEIGHT / (2 * self.MODULUS) + weight / self.STIFFNESS
        self.assertAlmostEqual(sinks / expected, 1.0, delta=0.002)

    def test_a_column_of_them_sinks_by_its_weight(self):
        points, tetrahedra = column_of_tetrahedra(self.WIDTH, self.HEIGHT, 3, 10)
        cells = np.array(tetrahedra)
        cells[::3, 2:] = cells[::3, :1:-1]  # some programs have the opposite orientation
        for version in ("gmsh22", "gmsh"):
            with self.subTest(version):
                self.meshio.write(self.path("column.msh"), self.meshio.Mesh(points, [("tetra", cells)]),
                                  file_format=version, binary=False)
                blocks = quoin.read_blocks(self.path("column.msh"), material="stone", rigid=False)
                self.assertEqual(len(blocks), 1)
                self.assert_sinks_by_its_weight(blocks, len(tetrahedra))

    def test_a_column_that_gmsh_has_meshed_too(self):
        count = mesh_boxes(self, "column.msh", [(0, 0, 0, self.WIDTH, self.HEIGHT, self.WIDTH)], 0.2)
        blocks = quoin.read_blocks(self.path("column.msh"), material="stone", rigid=False)
        self.assertGreater(count, 100)
        self.assert_sinks_by_its_weight(blocks, count)

    def test_a_scene_with_them_is_written_and_runs_from_the_command_line(self):
        points, tetrahedra = column_of_tetrahedra(self.WIDTH, self.HEIGHT, 2, 4)
        scene = self.column([quoin.Block(name="column", material="stone", rigid=False, vertices=points,
                                         tetrahedra=tetrahedra)])
        scene.stage[0].duration = 0.05
        scene.output.frames, scene.output.frames_of = 2, "last"
        scene.write(self.path("scene.toml"))
        self.assertEqual(quoin.Scene.load(self.path("scene.toml")), scene)
        for arguments in (("check", "scene.toml"), ("run", "scene.toml", "--out", "out"), ("report", "out")):
            done = self.command(*arguments)
            self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(quoin.run(scene).summary["zones"], len(tetrahedra))

    def test_what_is_wrong_with_them_is_told_with_its_place(self):
        points, tetrahedra = column_of_tetrahedra(self.WIDTH, self.HEIGHT, 2, 4)

        def block(**keys):
            return quoin.Block(**{"name": "column", "material": "stone", "rigid": False, "vertices": points,
                                  "tetrahedra": tetrahedra, **keys})
        inverted = [list(t) for t in tetrahedra]
        inverted[7] = [inverted[7][i] for i in (0, 2, 1, 3)]
        for made, words in ((block(rigid=True), "tetrahedra.*only with rigid = false"),
                            (block(zone_edge=0.1), "zone_edge.*not beside tetrahedra"),
                            (block(tetrahedra=[[0, 1, 2, 99999]]), "tetrahedra.*less than 45"),
                            (block(tetrahedra=[[0, 1, 2]]), "tetrahedra.*four for each tetrahedron"),
                            (block(tetrahedra=inverted), "tetrahedron 7 near .* is inverted"),
                            (block(tetrahedra=tetrahedra[:50] + tetrahedra[51:]), "column.*inside the hull"),
                            (block(tetrahedra=tetrahedra + tetrahedra[:1]), "column.*(overlap|share)")):
            with self.assertRaisesRegex(quoin.BadInput, words):
                quoin.Simulation(self.column([made]))
        with open(self.path("cube.ply"), "w", encoding="utf-8") as file:
            file.write("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                       "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
                       "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n")
        with self.assertRaisesRegex(quoin.BadInput, "no tetrahedra that could be the zones"):
            quoin.read_blocks(self.path("cube.ply"), material="stone", rigid=False)


class Compressed(Folder):
    def test_compressed_results_say_the_same(self):
        try:
            from vtkmodules.util.numpy_support import vtk_to_numpy
            from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
        except ImportError:
            self.skipTest("VTK is not installed (python3-vtk9)")

        def read(path):
            reader = vtkXMLUnstructuredGridReader()
            reader.SetFileName(path)
            reader.Update()
            self.assertEqual(reader.GetErrorCode(), 0)
            grid = reader.GetOutput()
            arrays = {d.GetArrayName(i): vtk_to_numpy(d.GetArray(i)) for d in (grid.GetPointData(), grid.GetCellData())
                      for i in range(d.GetNumberOfArrays())}
            return {**arrays, "points": vtk_to_numpy(grid.GetPoints().GetData())}
        for name, options in (("raw", []), ("packed", ["--compressed"])):
            done = self.command("run", SMALL_WALL, "--out", name, "--set", "output.plots=false", *options)
            self.assertEqual(done.returncode, 0, done.stderr)
        for file in ("blocks_0003.vtu", "joints_0003.vtu"):
            raw, packed = (read(self.path(f"{name}/{file}")) for name in ("raw", "packed"))
            self.assertEqual(raw.keys(), packed.keys())
            self.assertGreater(len(raw), 4)
            for key in raw:
                np.testing.assert_array_equal(raw[key], packed[key])
            self.assertLess(os.path.getsize(self.path("packed/" + file)), 0.7 * os.path.getsize(self.path("raw/" + file)))
        pages = []
        for name in ("raw", "packed"):
            self.assertEqual(self.command("report", name).returncode, 0)
            with open(self.path(name + "/report.html"), encoding="utf-8") as file:
                pages.append(file.read().split('class="data">')[1].split("<")[0])
        self.assertEqual(*pages)


if __name__ == "__main__":
    unittest.main(verbosity=2)
