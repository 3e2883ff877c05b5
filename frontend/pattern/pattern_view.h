#pragma once
#include <Eigen/Core>

#include "frontend/pattern/pattern_model.h"

namespace tagtwist::internal {

/// How a pixel sees a tag, by the model of PatternState. S: a number, or an Eigen array of them for
/// as many pixels; T: its scalar.
template <typename S>
struct PatternView {
  S u, v;        // tag coordinates
  S a, b, c, d;  // d(cell coordinates)/d(pixel) = [a b; c d]
  S uu, uv, vv;  // covariance of the blur over the tag [cells^2]
};

/// g: tag_from_pixel; h: half the square's side [cells]; s: blur in the image [px^2].
template <typename S, typename T>
PatternView<S> ViewPattern(const Eigen::Matrix<T, 3, 3>& g, T h, const Eigen::Matrix<T, 3, 1>& s,
                           const S& x, const S& y) {
  PatternView<S> out;
  const S scale = T(1) / (g(2, 0) * x + g(2, 1) * y + g(2, 2)), hs = h * scale;
  out.u = (g(0, 0) * x + g(0, 1) * y + g(0, 2)) * scale;
  out.v = (g(1, 0) * x + g(1, 1) * y + g(1, 2)) * scale;
  out.a = hs * (g(0, 0) - out.u * g(2, 0));
  out.b = hs * (g(0, 1) - out.u * g(2, 1));
  out.c = hs * (g(1, 0) - out.v * g(2, 0));
  out.d = hs * (g(1, 1) - out.v * g(2, 1));
  const S &a = out.a, &b = out.b, &c = out.c, &d = out.d;
  out.uu = a * a * s[0] + T(2) * a * b * s[1] + b * b * s[2];
  out.uv = a * c * s[0] + (a * d + b * c) * s[1] + b * d * s[2];
  out.vv = c * c * s[0] + T(2) * c * d * s[1] + d * d * s[2];
  return out;
}

/// The light on a pixel.
template <typename S>
struct PatternLight {
  S x, y;          // (pixel - origin) / radius
  S illumination;  // as in PatternState
};

/// Derivative of the pixel's grey by the unknowns of PatternState, one after the other into
/// out(0) .. out(15).
template <typename S, typename T, typename Out>
void PatternDerivatives(const PatternView<S>& view, const PatternSample<S>& sample,
                        const PatternLight<S>& light, T h, T black, T gain, Out&& out) {
  const S &u = view.u, &v = view.v, &uu = view.uu, &uv = view.uv, &vv = view.vv;
  const S &a = view.a, &b = view.b, &c = view.c, &d = view.d;
  const S k = light.illumination * gain, du = k * h * sample.u, dv = k * h * sample.v;
  const S along = -(du * u + dv * v);
  const S xx = T(0.5) * k * sample.uu, xy = k * sample.uv, yy = T(0.5) * k * sample.vv;
  out(0) = du * u + T(2) * xx * uu + xy * uv;
  out(1) = du * v + T(2) * xx * uv + xy * vv;
  out(2) = du;
  out(3) = dv * u + T(2) * yy * uv + xy * uu;
  out(4) = dv * v + T(2) * yy * vv + xy * uv;
  out(5) = dv;
  out(6) = along * u - u * (T(4) * xx * uu + T(3) * xy * uv + T(2) * yy * vv) -
           v * (xy * uu + T(2) * yy * uv);
  out(7) = along * v - v * (T(2) * xx * uu + T(3) * xy * uv + T(4) * yy * vv) -
           u * (T(2) * xx * uv + xy * vv);
  out(8) = xx * a * a + xy * a * c + yy * c * c;
  out(9) = T(2) * xx * a * b + xy * (a * d + b * c) + T(2) * yy * c * d;
  out(10) = xx * b * b + xy * b * d + yy * d * d;
  const S reflected = black + gain * sample.value;
  out(11) = light.illumination;
  out(12) = light.illumination * sample.value;
  out(13) = reflected * light.x;
  out(14) = reflected * light.y;
  out(15) = reflected * (light.x * light.x + light.y * light.y);
}

}  // namespace tagtwist::internal
