"""How skin and bone take the light: a few lines of GLSL that replace VTK's light.

Every sum is in the camera's frame, so that each view has the same studio: a warm key from the upper left, a cool fill from
the right, light from above. Light that enters skin comes out reddened some millimetres further: the terminator is
wrapped, red furthest. At grazing angles translucent skin is denser, as a glass is, so that its outline reads.
"""

from __future__ import annotations

from typing import Any

STUDIO = """
vec3 N = normalize(normalVCVSOutput);
vec3 V = normalize(-vertexVC.xyz);
vec3 key = normalize(vec3(-0.45, 0.65, 0.62));
vec3 fill = normalize(vec3(0.75, 0.05, 0.55));
float facing = clamp(dot(N, V), 0.0, 1.0);
float up = 0.5 + 0.5 * N.y;
float sheen = max(dot(N, normalize(key + V)), 0.0);
vec3 wrapped = clamp((vec3(dot(N, key)) + spread) / (vec3(1.0) + spread), 0.0, 1.0);
vec3 ambient = mix(low, vec3(0.45, 0.46, 0.48), up);
vec3 lit = diffuseColor * (ambient + 0.60 * wrapped * vec3(1.0, 0.975, 0.94)
           + 0.20 * clamp((dot(N, fill) + 0.3) / 1.3, 0.0, 1.0) * vec3(0.88, 0.93, 1.0));
lit += (gloss.x * pow(sheen, 14.0) + gloss.y * pow(sheen, 60.0)) * vec3(1.0, 0.97, 0.93);
lit += 0.09 * pow(1.0 - facing, 3.0) * up * vec3(1.0, 0.88, 0.80);
"""
SKIN = "vec3 spread = vec3(0.42, 0.20, 0.14); vec3 low = vec3(0.40, 0.325, 0.305); vec2 gloss = vec2(0.085, 0.05);"
BONE = "vec3 spread = vec3(0.30, 0.24, 0.18); vec3 low = vec3(0.38, 0.34, 0.30); vec2 gloss = vec2(0.07, 0.08);"

# Density of translucent skin: (looked straight at, at its outline). The far side is fainter, so that the bones stand out.
FAR_SIDE = (0.10, 0.34)
NEAR_SIDE = (0.20, 0.86)
HOOK = "//VTK::Light::Impl"


def paint(actor: Any, material: str, density: tuple[float, float] | None = None) -> None:
    """Give an actor a material (``SKIN`` or ``BONE``), opaque or with a ``density`` that grows towards the outline."""
    if density is None:
        end = "fragOutput0.rgb = lit;"
    else:
        straight, outline = density
        end = f"fragOutput0 = vec4(lit, {straight:.4f} + {outline - straight:.4f} * pow(1.0 - facing, 2.0));"
    actor.GetShaderProperty().AddFragmentShaderReplacement(HOOK, True, f"{HOOK}\n{material}\n{STUDIO}\n{end}\n", False)
