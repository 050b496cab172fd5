#version 460
// Pictures that an engine has rendered, a layer for each individual, as klieg's own: the encoded
// luminance of the object pixels, and which of them have a channel that is burnt out. Reference: cpu::pictures.
#extension GL_GOOGLE_include_directive : require
#define FORMAT rgba32f
#include "pictures.glsl"
