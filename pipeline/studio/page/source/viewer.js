// A take in three dimensions: binary glTF, turned by the mouse, at any time of its motion.

import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

export class Viewer {
  constructor(canvas, { onTheSpot = false } = {}) {
    this.canvas = canvas;
    this.onTheSpot = onTheSpot;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(onTheSpot ? "#e9ecef" : "#c9d9e6");
    this.camera = new THREE.PerspectiveCamera(35, 1, 0.02, 400);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.draw());
    this.scene.add(new THREE.HemisphereLight("#ffffff", "#8a7f70", 1.6));
    const sun = new THREE.DirectionalLight("#fff3df", 2.2);
    sun.position.set(2, 5, 3);
    this.scene.add(sun);
    if (onTheSpot) {
      this.grid = new THREE.GridHelper(24, 24, "#b9b4a8", "#d7d3c8");
      this.scene.add(this.grid);
    }
    this.model = null;
    this.roots = new Map();
    this.time = 0;
    this.filmCamera = null;
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.resize();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  async show(bytes) {
    const gltf = await new GLTFLoader().parseAsync(bytes, "");
    const isFirst = this.model === null;
    if (this.model) {
      this.scene.remove(this.model);
      this.model.traverse((object) => {
        object.geometry?.dispose();
        object.skeleton?.dispose();
        object.material?.dispose();
      });
      this.mixer.stopAllAction();
    }
    this.model = gltf.scene;
    this.scene.add(this.model);
    this.roots = new Map();
    this.model.traverse((object) => {
      object.frustumCulled = false;
      const who = object.userData.performer;
      if (who && !object.isMesh && !this.roots.has(who)) this.roots.set(who, object);
    });
    this.mixer = new THREE.AnimationMixer(this.model);
    if (gltf.animations.length) {
      const action = this.mixer.clipAction(gltf.animations[0]);
      action.setLoop(THREE.LoopOnce);
      action.clampWhenFinished = true;
      action.play();
    }
    this.seek(this.time);
    if (isFirst || this.onTheSpot) this.fit(isFirst);
    this.draw();
  }

  // Creatures alone: the ground is far larger than what is watched.
  bounds() {
    const box = new THREE.Box3();
    const place = new THREE.Vector3();
    for (const [, root] of this.roots) {
      root.traverse((object) => box.expandByPoint(object.getWorldPosition(place)));
    }
    return box;
  }

  // Looks at the creatures; where nothing forces it, only when their size has become another.
  fit(isForced = true) {
    const box = this.bounds();
    if (box.isEmpty()) return;
    const middle = box.getCenter(new THREE.Vector3());
    const size = Math.max(box.getSize(new THREE.Vector3()).length(), 0.5);
    if (!isForced && Math.abs(Math.log(size / this.fitted)) < 0.25) return;
    this.fitted = size;
    this.controls.target.copy(middle);
    this.camera.position.copy(middle).add(new THREE.Vector3(0.9, 0.55, 1.1).multiplyScalar(size * 1.15));
    this.camera.near = size / 100;
    this.camera.updateProjectionMatrix();
    this.controls.update();
  }

  seek(time) {
    this.time = time;
    if (!this.model) return;
    this.mixer.setTime(time);
    if (this.onTheSpot) {
      const [root] = this.roots.values();
      this.model.position.set(0, 0, 0);
      this.model.updateMatrixWorld(true);
      const at = root ? root.getWorldPosition(new THREE.Vector3()) : new THREE.Vector3();
      this.model.position.set(-at.x, 0, -at.z);
      this.grid.position.set(-(at.x % 1), 0, -(at.z % 1));
    }
  }

  // From the film's camera: origin, target and vertical field of view of a frame.
  lookAs(pose) {
    if (!pose) return;
    const [x, y, z, tx, ty, tz, fov] = pose;
    this.camera.position.set(x, y, z);
    this.camera.fov = fov;
    this.camera.updateProjectionMatrix();
    this.camera.lookAt(tx, ty, tz);
    this.controls.target.set(tx, ty, tz);
  }

  // From above: x to the right, z down, `half` metres up and down from the middle; null ends it.
  seeFromAbove(view) {
    this.above = null;
    if (view) {
      const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
      const wide = (view.half * width) / height;
      this.above = new THREE.OrthographicCamera(-wide, wide, view.half, -view.half, 0.1, 4000);
      this.above.up.set(0, 0, -1);
      this.above.position.set(view.x, 2000, view.z);
      this.above.lookAt(view.x, 0, view.z);
    }
    this.draw();
  }

  // The performer at a place of the canvas.
  performerAt(event) {
    if (!this.model) return null;
    const box = this.canvas.getBoundingClientRect();
    const x = ((event.clientX - box.left) / box.width) * 2 - 1;
    const y = 1 - ((event.clientY - box.top) / box.height) * 2;
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2(x, y), this.camera);
    for (const hit of ray.intersectObject(this.model, true)) {
      for (let object = hit.object; object; object = object.parent) {
        if (object.userData.performer) return object.userData.performer;
      }
    }
    return null;
  }

  get triangles() {
    return this.renderer.info.render.triangles;
  }

  draw() {
    this.renderer.render(this.scene, this.above ?? this.camera);
  }
}
