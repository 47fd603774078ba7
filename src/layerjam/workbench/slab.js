// A unit box with drawn edges. A see-through one is drawn last and hides nothing behind it.
import { THREE } from "nicegui-scene";

export default class Slab {
  create_mesh(color, opacity) {
    const through = opacity < 1;
    const material = new THREE.MeshPhongMaterial({
      color, opacity, transparent: through, depthWrite: !through,
      polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
    });
    const geometry = new THREE.BoxGeometry(1, 1, 1);
    const mesh = new THREE.Mesh(geometry, material);
    const line = new THREE.LineBasicMaterial({ color: "#1c2530", opacity: 0.45, transparent: true });
    mesh.add(new THREE.LineSegments(new THREE.EdgesGeometry(geometry), line));
    mesh.renderOrder = through ? 10 : 0;
    return mesh;
  }
}
