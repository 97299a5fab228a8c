"""How skin and bone take the light: a few lines of GLSL that replace VTK's light.

Every sum is in the camera's frame, so that each view has the same studio: a warm key from the upper left, a cool fill from
the right, light from above. Light that enters skin comes out reddened some millimetres further: the terminator is
wrapped, red furthest. At grazing angles translucent skin is denser, as a glass is, so that its outline reads.
"""

from __future__ import annotations

from typing import Any

# The lens is long, so the eye counts as straight ahead everywhere, (0, 0, 1): half vectors are constants. Powers are products:
# on a software renderer every ``pow`` is felt.
STUDIO = """
vec3 N = normalize(normalVCVSOutput);
float facing = clamp(N.z, 0.0, 1.0);
float up = 0.5 + 0.5 * N.y;
float edge = 1.0 - facing;
float k = dot(N, vec3(-0.4480, 0.6471, 0.6170));
vec3 wrapped = clamp((vec3(k) + spread) / (vec3(1.0) + spread), 0.0, 1.0);
float fill = clamp((dot(N, vec3(0.8053, 0.0537, 0.5905)) + 0.3) * 0.7692, 0.0, 1.0);
vec3 lit = diffuseColor * (mix(low, vec3(0.45, 0.46, 0.48), up) + wrapped * vec3(0.60, 0.585, 0.564)
           + fill * vec3(0.176, 0.186, 0.20));
float s2 = max(dot(N, vec3(-0.2491, 0.3599, 0.8992)), 0.0); s2 *= s2;
float s8 = s2 * s2; s8 *= s8;
float s16 = s8 * s8;
float s64 = s16 * s16; s64 *= s64;
lit += (gloss.x * s16 + gloss.y * s64) * vec3(1.0, 0.97, 0.93) + (0.09 * edge * edge * edge * up) * vec3(1.0, 0.88, 0.80);
"""
# The key low from the left and little else, for small relief: a bulge of 2 mm throws its own shade.
RAKING = (
    STUDIO.replace("vec3(-0.4480, 0.6471, 0.6170)", "vec3(-0.8480, 0.4240, 0.3180)")
    .replace("vec3(-0.2491, 0.3599, 0.8992)", "vec3(-0.5222, 0.2611, 0.8119)")
    .replace("vec3(0.60, 0.585, 0.564)", "vec3(0.90, 0.878, 0.846)")
    .replace("mix(low, vec3(0.45, 0.46, 0.48), up)", "0.7 * mix(low, vec3(0.45, 0.46, 0.48), up)")
)
LIGHTS = {"studio": STUDIO, "raking": RAKING}
SKIN = "vec3 spread = vec3(0.42, 0.20, 0.14); vec3 low = vec3(0.40, 0.325, 0.305); vec2 gloss = vec2(0.085, 0.05);"
BONE = "vec3 spread = vec3(0.30, 0.24, 0.18); vec3 low = vec3(0.38, 0.34, 0.30); vec2 gloss = vec2(0.07, 0.08);"

# Density of translucent skin: (looked straight at, at its outline). The far side is fainter, so that the bones stand out.
FAR_SIDE = (0.10, 0.34)
NEAR_SIDE = (0.20, 0.86)
HOOK = "//VTK::Light::Impl"


def paint(actor: Any, material: str, density: tuple[float, float] | None = None, light: str = "studio") -> None:
    """Give an actor a material (``SKIN`` or ``BONE``) under a ``light``, opaque or with a ``density`` that grows towards the outline."""
    if density is None:
        end = "fragOutput0.rgb = lit;"
    else:
        straight, outline = density
        end = f"fragOutput0 = vec4(lit, {straight:.4f} + {outline - straight:.4f} * edge * edge);"
    actor.GetShaderProperty().AddFragmentShaderReplacement(HOOK, True, f"{HOOK}\n{material}\n{LIGHTS[light]}\n{end}\n", False)
