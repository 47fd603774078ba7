// A closed surface of triangles with its sharp edges drawn; numbers come as base64, x y z in float32.
import { THREE } from "nicegui-scene";

const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;

export default class Solid {
  create_mesh(color, corners, triangles) {
    const geometry = new THREE.BufferGeometry();
    const places = new THREE.BufferAttribute(new Float32Array(bytes(corners)), 3);
    geometry.setAttribute("position", places);
    geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(bytes(triangles)), 1));
    const material = new THREE.MeshPhongMaterial({
      color, flatShading: true, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
    });
    const mesh = new THREE.Mesh(geometry, material);
    const line = new THREE.LineBasicMaterial({ color: "#1c2530", opacity: 0.6, transparent: true });
    mesh.add(new THREE.LineSegments(new THREE.EdgesGeometry(geometry, 25), line));
    return mesh;
  }
}
