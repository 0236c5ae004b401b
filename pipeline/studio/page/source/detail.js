// Levels of detail: meshes with fewer triangles for performers that are small on the screen.
//
// A coarse mesh shares the vertices of the whole one; triangles whose corners fall together are gone.
// Vertices are clustered on a grid, apart by the node that they follow, so that legs stay apart.
// Source: Rossignac and Borrel 1993, with the vertex nearest to the mean of its cell for all of it.

import * as THREE from "three";

const LEVELS = 5; // each with half of the triangles of the one before
const CELL = 3.1; // area of a triangle, in squares of the cell it leaves, as measured; where it starts
const TRIES = 6; // cells of growing size until there are few enough triangles
const LEAST = 24; // triangles of a mesh that is not made coarser
const STEADY = 0.1; // levels within which a performer keeps its own

// A mesh with at most so many triangles, on the vertices of another, where that has enough vertices.
export function coarse(geometry, triangles) {
  const { position } = geometry.attributes;
  let cell = Math.sqrt((CELL * areaOf(position, geometry.index.array)) / triangles);
  let kept = clustered(geometry, cell);
  for (let k = 1; k < TRIES && kept.length / 3 > triangles; k++) {
    cell *= Math.max(Math.sqrt(kept.length / 3 / triangles), 1.05);
    const fewer = clustered(geometry, cell);
    // Nothing of a small part would be left.
    if (!fewer.length) break;
    kept = fewer;
  }
  const made = new THREE.BufferGeometry();
  for (const [name, attribute] of Object.entries(geometry.attributes)) made.setAttribute(name, attribute);
  made.setIndex(kept.length ? kept : Array.from(geometry.index.array));
  return made;
}

// The triangles that are left where all vertices of a cell are one.
function clustered(geometry, cell) {
  const { position, skinIndex, skinWeight } = geometry.attributes;
  const index = geometry.index.array;
  const clusters = new Map();
  const owner = new Int32Array(position.count);
  const { min, max } = new THREE.Box3().setFromBufferAttribute(position);
  const [nx, ny, nz] = max.sub(min).toArray().map((size) => Math.floor(size / cell) + 1);
  const key = (v) => {
    const node = skinIndex ? skinIndex.getComponent(v, skinWeight.getY(v) > skinWeight.getX(v) ? 1 : 0) : 0;
    const x = Math.floor((position.getX(v) - min.x) / cell);
    const y = Math.floor((position.getY(v) - min.y) / cell);
    return ((node * nx + x) * ny + y) * nz + Math.floor((position.getZ(v) - min.z) / cell);
  };
  for (let v = 0; v < position.count; v++) {
    const own = key(v);
    let cluster = clusters.get(own);
    if (!cluster) clusters.set(own, (cluster = { number: clusters.size, count: 0, sum: [0, 0, 0], best: -1, away: Infinity }));
    cluster.count += 1;
    for (let k = 0; k < 3; k++) cluster.sum[k] += position.getComponent(v, k);
    owner[v] = cluster.number;
  }
  const listed = [...clusters.values()];
  for (let v = 0; v < position.count; v++) {
    const cluster = listed[owner[v]];
    let away = 0;
    for (let k = 0; k < 3; k++) away += (position.getComponent(v, k) - cluster.sum[k] / cluster.count) ** 2;
    if (away < cluster.away) Object.assign(cluster, { best: v, away });
  }
  const kept = [];
  for (let i = 0; i < index.length; i += 3) {
    const [a, b, c] = [owner[index[i]], owner[index[i + 1]], owner[index[i + 2]]];
    if (a !== b && b !== c && c !== a) kept.push(listed[a].best, listed[b].best, listed[c].best);
  }
  return kept;
}

function areaOf(position, index) {
  const [a, b, c] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
  let sum = 0;
  for (let i = 0; i < index.length; i += 3) {
    a.fromBufferAttribute(position, index[i]);
    b.fromBufferAttribute(position, index[i + 1]).sub(a);
    c.fromBufferAttribute(position, index[i + 2]).sub(a);
    sum += b.cross(c).length() / 2;
  }
  return sum;
}

// Chooses the levels of all performers of a model.
export class Detail {
  constructor(model, roots, budget) {
    this.budget = budget;
    this.performers = [];
    for (const [name, root] of roots) this.performers.push({ name, root, meshes: [], triangles: 0, level: 0, radius: 1 });
    const known = new Map(this.performers.map((one) => [one.name, one]));
    this.others = 0;
    model.traverse((mesh) => {
      if (!mesh.isMesh) return;
      const owner = known.get(mesh.userData.performer);
      if (!owner) return void (this.others += mesh.geometry.index.count / 3);
      owner.meshes.push({ mesh, levels: [mesh.geometry] });
      owner.triangles += mesh.geometry.index.count / 3;
    });
    for (const one of this.performers) one.radius = reach(one.root);
    this.place = new THREE.Vector3();
  }

  // Shares the triangles out by size on the screen; all of them where the view is at rest.
  choose(camera, isMoving) {
    const left = Math.max(this.budget - this.others, this.budget / 4);
    let whole = 0;
    for (const one of this.performers) {
      const away = Math.max(one.root.getWorldPosition(this.place).distanceTo(camera.position), one.radius);
      one.share = (one.radius / away) ** 2;
      whole += one.share;
    }
    for (const one of this.performers) {
      const allowed = Math.max((left * one.share) / whole, 1);
      const wished = isMoving ? Math.min(Math.max(Math.log2(one.triangles / allowed), 0), LEVELS) : 0;
      // A finer one only when it is clearly allowed.
      const isSteady = isMoving && wished <= one.level && wished > one.level - 1 - STEADY;
      const level = Math.ceil(wished);
      if (level !== one.level && !isSteady) this.#set(one, level);
    }
  }

  #set(one, level) {
    one.level = level;
    for (const { mesh, levels } of one.meshes) {
      if (!levels[level]) {
        const triangles = levels[0].index.count / 3;
        const wanted = Math.max(triangles / 2 ** level, LEAST);
        levels[level] = wanted < triangles ? coarse(levels[0], wanted) : levels[0];
      }
      mesh.geometry = levels[level];
    }
  }

  dispose() {
    for (const { meshes } of this.performers) {
      for (const { levels } of meshes) for (const geometry of levels) geometry?.dispose();
    }
  }
}

// Gives all skins of a performer one skeleton, whose matrices are then sent once for all of them.
export function shareSkeletons(meshes) {
  const owners = new Map();
  for (const mesh of meshes) {
    const who = mesh.userData.performer;
    if (mesh.isSkinnedMesh) owners.set(who, [...(owners.get(who) ?? []), mesh]);
  }
  for (const skins of owners.values()) {
    const numbers = new Map();
    const inverses = [];
    for (const { skeleton } of skins) {
      skeleton.bones.forEach((bone, i) => {
        if (numbers.has(bone)) return;
        numbers.set(bone, numbers.size);
        inverses.push(skeleton.boneInverses[i]);
      });
    }
    const whole = new THREE.Skeleton([...numbers.keys()], inverses);
    for (const mesh of skins) {
      const { skinIndex } = mesh.geometry.attributes;
      const own = mesh.skeleton.bones.map((bone) => numbers.get(bone));
      mesh.geometry.setAttribute("skinIndex", new THREE.BufferAttribute(Uint16Array.from(skinIndex.array, (i) => own[i]), 4));
      mesh.skeleton.dispose();
      mesh.bind(whole, mesh.bindMatrix);
    }
  }
}

// How far a performer reaches from its root.
function reach(root) {
  const [middle, place] = [root.getWorldPosition(new THREE.Vector3()), new THREE.Vector3()];
  let most = 0.05;
  root.traverse((object) => (most = Math.max(most, object.getWorldPosition(place).distanceTo(middle))));
  return most;
}
