// Visible triangles of a large model. Most faces of a wall are covered by neighbours and are left out.

const COVER = {share: 0.97, gap: 0.05, along: 0.98, aslant: 0.2};  // over the face's area; over the size of a block, as drawn; cosine between normals of joint and face; sine of the angle to the view

const WAYS = [null, [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]];  // directions of normals; null: along no axis

class Faces {
  constructor(model) {
    this.model = model;
    const triangle = model.array('triangle'), block = model.array('block'), p = model.array('position');
    this.of = new Int32Array(triangle.length / 3);  // face by triangle
    this.area = []; this.normal = []; this.level = [];  // by face
    const first = new Map(), n = [0, 0, 0];  // faces by block
    for (let t = 0; t < this.of.length; ++t) {
      const [a, b, c] = [0, 1, 2].map(k => 3 * triangle[3 * t + k]);
      const u = [p[b] - p[a], p[b + 1] - p[a + 1], p[b + 2] - p[a + 2]], v = [p[c] - p[a], p[c + 1] - p[a + 1], p[c + 2] - p[a + 2]];
      n[0] = u[1] * v[2] - u[2] * v[1]; n[1] = u[2] * v[0] - u[0] * v[2]; n[2] = u[0] * v[1] - u[1] * v[0];
      const size = Math.hypot(...n) || 1e-30, normal = n.map(x => x / size), level = normal[0] * p[a] + normal[1] * p[a + 1] + normal[2] * p[a + 2];
      const b0 = block[triangle[3 * t]], known = first.get(b0) || [];
      let face = this.find(known, normal, level, 1e-3 * model.block);
      if (face < 0) {
        face = this.area.push(0) - 1;
        this.normal.push(normal); this.level.push(level); known.push(face); first.set(b0, known);
      }
      this.area[face] += size / 2;
      this.of[t] = face;
    }
    this.ofJoints(first);
  }
  find(faces, normal, level, near) {
    for (const f of faces) {
      const m = this.normal[f], same = normal[0] * m[0] + normal[1] * m[1] + normal[2] * m[2];
      if (Math.abs(same) > COVER.along && Math.abs(Math.sign(same) * level - this.level[f]) < near) return f;
    }
    return -1;
  }
  // Indices of the two faces of each joint; -1: no face fits.
  ofJoints(first) {
    const {array} = this.model, sides = [array('joint_a'), array('joint_b')], axis = array('joint_axis0'), place = array('joint_place0');
    this.sides = sides.map(side => Int32Array.from(side, (b, j) => {
      const normal = [axis[3 * j], axis[3 * j + 1], axis[3 * j + 2]];
      const level = normal[0] * place[3 * j] + normal[1] * place[3 * j + 1] + normal[2] * place[3 * j + 2];
      return this.find(first.get(b) || [], normal, level, COVER.gap * this.model.block);
    }));
  }
  // Corners of the triangles that are visible in a frame.
  seen(frame, magnified) {
    const {model} = this, {array} = model, covered = new Float32Array(this.area.length);
    const [area, opening, slip] = ['area', 'opening', 'slip'].map(what => array(`joint_${what}${frame}`)), a = array('joint_a'), b = array('joint_b');
    for (let j = 0; j < area.length; ++j) {
      if (magnified * (Math.abs(opening[j]) + Math.abs(slip[j])) > COVER.gap * model.block || model.hidden(a[j]) || model.hidden(b[j])) continue;
      for (const side of this.sides) if (side[j] >= 0) covered[side[j]] += area[j];
    }
    const triangle = array('triangle'), block = array('block'), lists = WAYS.map(() => []);
    for (let t = 0; t < this.of.length; ++t) {
      const face = this.of[t];
      if (covered[face] <= COVER.share * this.area[face] && !model.hidden(block[triangle[3 * t]])) lists[this.wayOf(t)].push(t);
    }
    const to = new Uint32Array(3 * lists.reduce((sum, list) => sum + list.length, 0));
    let count = 0;
    this.groups = lists.map((list, way) => {
      const start = count;
      for (const t of list) for (let k = 0; k < 3; ++k) to[count++] = triangle[3 * t + k];
      return {start, count: count - start, way: WAYS[way]};
    });
    return to;
  }
  // Index into WAYS of the axis along the normal of a triangle as drawn.
  wayOf(t) {
    const p = this.model.position.array, triangle = this.model.array('triangle');
    const a = 3 * triangle[3 * t], b = 3 * triangle[3 * t + 1], c = 3 * triangle[3 * t + 2];
    const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2], vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx, size = COVER.along * Math.sqrt(x * x + y * y + z * z);
    return x > size ? 1 : -x > size ? 2 : y > size ? 3 : -y > size ? 4 : z > size ? 5 : -z > size ? 6 : 0;
  }
  // Draws only groups that face the viewer. Normals of a group along an axis are within 11 degrees of it.
  facing(geometry, towards) {
    geometry.clearGroups();
    for (const {start, count, way} of this.groups)
      if (count && (!way || way[0] * towards.x + way[1] * towards.y + way[2] * towards.z > -COVER.aslant)) geometry.addGroup(start, count, 0);
  }
}
