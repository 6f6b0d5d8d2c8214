// Cracks of a frame: bars where joints of the lattice meet the surface, dots elsewhere. Both have a light border that
// sets them off from a surface of similar colour.

const CRACK = {share: 0.07, narrowest: 1.5, widest: 4, border: 1.2};  // over the size of a block; pixels; pixels on each side
const BAR_SHADER = `attribute vec3 start, end, paint; uniform vec2 room; uniform float width, lift; varying vec3 tint;
void main() {
  vec4 a = projectionMatrix * modelViewMatrix * vec4(start, 1.0), b = projectionMatrix * modelViewMatrix * vec4(end, 1.0);
  vec2 along = (b.xy - a.xy) * room;
  along /= max(length(along), 1e-9);
  gl_Position = mix(a, b, position.x) + vec4(position.y * vec2(-along.y, along.x) * width / room, -lift, 0.0);
  tint = paint;
}`;
const DOT_SHADER = `attribute vec3 paint; uniform float width, lift; varying vec3 tint;
void main() {
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0) - vec4(0.0, 0.0, lift, 0.0);
  gl_PointSize = width;
  tint = paint;
}`;
const PAINT_SHADER = `varying vec3 tint; uniform float light;
void main() { gl_FragColor = vec4(mix(tint, vec3(1.0), light), 1.0); }`;
const ROUND_SHADER = `varying vec3 tint; uniform float light;
void main() {
  if (length(gl_PointCoord - 0.5) > 0.5) discard;
  gl_FragColor = vec4(mix(tint, vec3(1.0), light), 1.0);
}`;

class Cracks {
  constructor(model) {
    this.model = model; this.array = model.array;
    this.bars = new THREE.InstancedBufferGeometry(); this.dots = new THREE.BufferGeometry();
    this.bars.setAttribute('position', new THREE.Float32BufferAttribute([0, -1, 0, 1, -1, 0, 1, 1, 0, 0, 1, 0], 3));
    this.bars.setIndex([0, 1, 2, 0, 2, 3]);
    this.layers = [];
    for (const border of [true, false]) {
      const of = (vertexShader, fragmentShader) => new THREE.ShaderMaterial({vertexShader, fragmentShader, side: THREE.DoubleSide,
        uniforms: {room: {value: new THREE.Vector2(1, 1)}, width: {value: 1}, lift: {value: 0}, light: {value: border ? 1 : 0}}});
      const bars = new THREE.Mesh(this.bars, of(BAR_SHADER, PAINT_SHADER)), dots = new THREE.Points(this.dots, of(DOT_SHADER, ROUND_SHADER));
      this.layers.push({bars, dots, border});
    }
    for (const {bars, dots} of this.layers) model.scene.add(bars, dots);
  }
  // Intact joints are not drawn. at, paint: both ends of bars; points, tints: dots.
  show(frame, magnified, wanted) {
    const {limit, head} = this.model, left = (all, i) => limit && all[i + limit.axis] > limit.at;
    const rim = this.array('rim'), moved = this.array('rim_moved' + frame), kind = this.array('crack' + frame);
    const step = head.range.rim_moved / 32767, colours = head.colours.cracks.map(c => new THREE.Color(c.colour).toArray());
    this.at = []; this.paint = []; this.points = []; this.tints = [];
    for (let s = 0; wanted && moved.length === rim.length && s < kind.length; s += 2) {
      if (kind[s] === 0 || kind[s + 1] === 0 || left(rim, 3 * s)) continue;
      for (let i = 3 * s; i < 3 * s + 6; ++i) this.at.push(rim[i] + magnified * step * moved[i]);
      const colour = colours[Math.max(kind[s], kind[s + 1])];
      this.paint.push(...colour, ...colour);
    }
    const points = this.array('points' + frame), points_moved = this.array('points_moved' + frame), kinds = this.array('point_crack' + frame);
    for (let worse = 1; wanted && worse < colours.length; ++worse)  // worse cracks are drawn over others
      for (let p = 0; p < kinds.length; ++p) {
        if (kinds[p] !== worse || left(points, 3 * p)) continue;
        for (let i = 3 * p; i < 3 * p + 3; ++i) this.points.push(points[i] + magnified * points_moved[i]);
        this.tints.push(...colours[worse]);
      }
    this.fill();
  }
  fill() {
    const ends = new THREE.InstancedInterleavedBuffer(Float32Array.from(this.at), 6);
    const paints = new THREE.InstancedInterleavedBuffer(Float32Array.from(this.paint), 6);
    this.bars.setAttribute('start', new THREE.InterleavedBufferAttribute(ends, 3, 0));
    this.bars.setAttribute('end', new THREE.InterleavedBufferAttribute(ends, 3, 3));
    this.bars.setAttribute('paint', new THREE.InterleavedBufferAttribute(paints, 3, 0));
    this.bars.maxInstancedCount = this.at.length / 6;
    this.dots.setAttribute('position', new THREE.Float32BufferAttribute(this.points, 3));
    this.dots.setAttribute('paint', new THREE.Float32BufferAttribute(this.tints, 3));
    for (const {bars, dots} of this.layers) { bars.visible = this.at.length > 0; dots.visible = this.points.length > 0; bars.frustumCulled = dots.frustumCulled = false; }
  }
  get count() { return this.at.length / 6 + this.points.length / 3; }
  // Width in proportion to the size of blocks in the picture. Cracks are lifted off the surface by this width.
  scale(pixelsPerMetre) {
    const {model} = this, ratio = window.devicePixelRatio || 1;
    const width = Math.max(CRACK.narrowest, Math.min(CRACK.widest, CRACK.share * pixelsPerMetre * model.block));
    const depth = model.camera.far - model.camera.near;
    for (const {bars, dots, border} of this.layers) {
      const all = width + (border ? 2 * CRACK.border : 0);
      for (const {material: {uniforms}} of [bars, dots]) {
        uniforms.room.value.set(model.width, model.height);
        uniforms.lift.value = (border ? 2 : 4) * width / pixelsPerMetre / depth;
      }
      bars.material.uniforms.width.value = all;
      dots.material.uniforms.width.value = 1.5 * all * ratio;
    }
  }
}
