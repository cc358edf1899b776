// Models that come as script files, because a page that was opened from a disk may not fetch.

const models = new Map();

// Each `<id>.glb.js` calls this with the GLB, packed by gzip, in base64.
globalThis.casaModel = (id, packed) => models.get(id)?.(packed);

// Bytes of the GLB of a script file. `address` leads to it from the page, `id` is what it calls the model.
export async function loadModel(address, id) {
  const packed = await new Promise((resolve, reject) => {
    const script = document.createElement("script");
    models.set(id, resolve);
    script.src = address;
    script.onload = () => reject(new Error(`${address} holds no model "${id}"`)); // does nothing once it is resolved
    script.onerror = () => reject(new Error(`${address} cannot be read`));
    document.head.append(script);
  });
  models.delete(id);
  const bytes = Uint8Array.from(atob(packed), (sign) => sign.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
