// Models that come as script files, because a page that was opened from a disk may not fetch.

const receivers = new Map();
// Address and id of each model that is on its way -> promise of its bytes.
const loading = new Map();

// Each `<id>.glb.js` calls this with the GLB, packed by gzip, in base64.
globalThis.casaModel = (id, packed) => receivers.get(id)?.(packed);

// Bytes of the GLB of a script file. `address` leads to it from the page, `id` is what it calls the model.
export function loadModel(address, id) {
  const key = `${address} ${id}`;
  if (!loading.has(key)) loading.set(key, load(address, id).finally(() => loading.delete(key)));
  return loading.get(key);
}

async function load(address, id) {
  const script = document.createElement("script");
  try {
    const packed = await new Promise((resolve, reject) => {
      receivers.set(id, resolve);
      script.src = address;
      script.onload = () => reject(new Error(`${address} holds no model "${id}"`)); // does nothing once it is resolved
      script.onerror = () => reject(new Error(`${address} cannot be read`));
      document.head.append(script);
    });
    const bytes = Uint8Array.from(atob(packed), (sign) => sign.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  } finally {
    receivers.delete(id);
    script.remove();
  }
}
