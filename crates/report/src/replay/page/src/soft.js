// Machines without a graphics card: a processor does its work.

const PROCESSORS = /swiftshader|llvmpipe|softpipe|software|basic render/i;

/** Whether there is none. */
export const IS_SOFT = (() => {
  const context = document.createElement("canvas").getContext("webgl2", { failIfMajorPerformanceCaveat: true });
  if (!context) return true;
  const names = context.getExtension("WEBGL_debug_renderer_info");
  const name = context.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : context.RENDERER);
  context.getExtension("WEBGL_lose_context")?.loseContext();
  return PROCESSORS.test(name);
})();

// Panels would be drawn by programs made for a card that is not there, which takes longer than all else.
if (IS_SOFT) {
  const { getContext } = HTMLCanvasElement.prototype;
  HTMLCanvasElement.prototype.getContext = function (kind, options) {
    return getContext.call(this, kind, kind === "2d" ? { ...options, willReadFrequently: true } : options);
  };
}
