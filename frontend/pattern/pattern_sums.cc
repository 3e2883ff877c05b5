#include "frontend/pattern/pattern_sums.h"

#include <algorithm>
#include <cmath>

#include "frontend/pattern/pattern_view.h"
#include "frontend/pattern/row_products.h"

namespace tagtwist::internal {
namespace {

constexpr int kChunk = RowProducts::kChunk;  // pixels that are worked on together
constexpr double kLeastNoiseGrey = 0.5;      // 8-bit steps and what the model leaves out

using Column = RowProducts::Column;

// Sizes of residuals, by counting.
class Magnitudes {
 public:
  void Add(float magnitude) {
    ++counts_[static_cast<size_t>(std::min(kBins - 1, magnitude * kPerGrey))];
    ++n_;
  }
  // 1.4826 times their median: the standard deviation of normal ones.
  double Deviation() const {
    size_t below = 0, bin = 0;
    while (below + counts_[bin] <= n_ / 2 && bin + 1 < counts_.size()) below += counts_[bin++];
    const double inside = (static_cast<double>(n_) / 2 - static_cast<double>(below)) /
                          std::max<double>(counts_[bin], 1);
    return std::max(1.4826 * (static_cast<double>(bin) + inside) / kPerGrey, kLeastNoiseGrey);
  }

 private:
  static constexpr float kPerGrey = 8, kBins = 8 * 256;
  std::array<uint32_t, static_cast<size_t>(kBins)> counts_{};
  size_t n_ = 0;
};

// What points see beyond an edge at a distance of x >= 0 standard deviations of the blur, and the
// derivatives by the distance [1/cell]: those of NormalTable's distribution, to 1e-5.
struct Beyond {
  Column share, density, slope;

  Beyond(const Column& cells, const Column& per_sigma) {
    constexpr auto kReach = static_cast<float>(NormalTable::kReach);
    constexpr float kCutOff = 5.7703e-4F;  // share of the normal distribution beyond kReach
    constexpr float kScale = 1 / (1 - 2 * kCutOff);
    const Column x = (cells * per_sigma).max(0.0F).min(kReach);
    const Column inside = ((kReach - x) * 1e4F).min(1.0F);
    const Column normal = (-0.5F * x * x).exp() * 0.39894228F;
    const Column t = (1 + 0.33267F * x).inverse();  // Abramowitz and Stegun 26.2.16
    share = ((normal * t * (0.4361836F + t * (-0.1201676F + t * 0.9372980F)) - kCutOff) * kScale)
                .max(0.0F);
    density = kScale * inside * normal * per_sigma;
    slope = x * density * per_sigma;
  }
};

// One pass over the pixels, a chunk at a time.
class PixelPass {
 public:
  PixelPass(const PatternModel& model, const NormalTable& normal, const PatternState& state,
            const Eigen::Vector2d& origin, double reach_grey);
  void Run(const PatternPixels& pixels, size_t stride);
  PatternSums Finish();

 private:
  int Take(const PatternPixels& pixels, size_t first, size_t stride);
  void Look();
  PatternSample<Column> SampleSharp() const;
  PatternSample<Column> SampleWide() const;
  void Weigh(const PatternSample<Column>& sample, int n);
  void Count(int n);

  const PatternModel& model_;
  const NormalTable& normal_;
  Eigen::Matrix3f tag_from_pixel_;
  Eigen::Vector3f blur_px2_, light_params_;
  Eigen::Vector2f light_origin_;
  float h_, black_, gain_, per_radius_, reach_;

  // The chunk: pixels, and what is made of them.
  Column x_, y_, grey_;
  std::array<bool, kChunk> follows_{};  // the pixel is the right neighbour of the one before
  PatternView<Column> view_;
  PatternLight<Column> light_;
  Column residual_, weight_, d_psi_;
  RowProducts::Rows rows_;

  RowProducts products_;
  std::array<float, 2> last_psi_{};  // of the pixel before and the one before that
  int run_ = 0;                      // pixels to the left of this one without a gap
  Magnitudes magnitudes_;
  PatternSums sums_;
};

PixelPass::PixelPass(const PatternModel& model, const NormalTable& normal,
                     const PatternState& state, const Eigen::Vector2d& origin, double reach_grey)
    : model_(model),
      normal_(normal),
      blur_px2_(state.blur_px2.cast<float>()),
      light_params_(state.light.cast<float>()),
      light_origin_((state.origin - origin).cast<float>()),
      h_(static_cast<float>(model.square_half())),
      black_(static_cast<float>(state.black)),
      gain_(static_cast<float>(state.gain)),
      per_radius_(static_cast<float>(1 / state.radius_px)),
      reach_(static_cast<float>(reach_grey)) {
  Eigen::Matrix3d from_origin = state.tag_from_pixel;
  from_origin.col(2) += state.tag_from_pixel.leftCols<2>() * origin;
  tag_from_pixel_ = (from_origin / from_origin(2, 2)).cast<float>();
}

// The next pixels; how many there are. The last one fills what is left of the chunk.
int PixelPass::Take(const PatternPixels& pixels, size_t first, size_t stride) {
  const size_t last = pixels.size() - 1;
  for (int i = 0; i < kChunk; ++i) {
    const size_t at = std::min(first + static_cast<size_t>(i) * stride, last);
    x_[i] = pixels.x[at];
    y_[i] = pixels.y[at];
    grey_[i] = pixels.grey[at];
    follows_[static_cast<size_t>(i)] = at > 0 && std::abs(x_[i] - pixels.x[at - 1] - 1) < 0.5F;
  }
  return static_cast<int>(std::min((last - first) / stride + 1, static_cast<size_t>(kChunk)));
}

void PixelPass::Look() {
  view_ = ViewPattern<Column, float>(tag_from_pixel_, h_, blur_px2_, x_, y_);
  light_.x = (x_ - light_origin_.x()) * per_radius_;
  light_.y = (y_ - light_origin_.y()) * per_radius_;
  light_.illumination = 1 + light_params_[0] * light_.x + light_params_[1] * light_.y +
                        light_params_[2] * (light_.x * light_.x + light_.y * light_.y);
}

// With a blur that does not reach beyond the neighbours of a point's own cell; as
// PatternModel::Around says.
PatternSample<Column> PixelPass::SampleSharp() const {
  const auto half = static_cast<float>(model_.pattern_half());
  const int last = model_.cells() - 1;
  const Column u = h_ * view_.u + half, v = h_ * view_.v + half;
  Column left_of, above;  // the edges of a point's own cell
  std::array<Column, 9> c;
  for (int i = 0; i < kChunk; ++i) {
    // Written so that a value that is not a number ends at a bound.
    const int column = static_cast<int>(std::min(static_cast<float>(last), std::max(0.0F, u[i])));
    const int row = static_cast<int>(std::min(static_cast<float>(last), std::max(0.0F, v[i])));
    left_of[i] = static_cast<float>(column);
    above[i] = static_cast<float>(row);
    const auto& around = model_.Around(column, row);
    for (size_t k = 0; k < 9; ++k) c[k][i] = around[k];
  }
  const auto sigma_inverse = [](const Column& variance) -> Column {
    return variance.max(1e-6F).rsqrt();
  };
  const Column per_su = sigma_inverse(view_.uu), per_sv = sigma_inverse(view_.vv);
  const Beyond l(u - left_of, per_su), r(left_of + 1 - u, per_su);
  const Beyond t(v - above, per_sv), b(above + 1 - v, per_sv);
  // Lines through the cell, above it and below it; then their derivatives along u.
  const Column above0 = c[3] + l.share * c[4] + r.share * c[5];
  const Column below0 = c[6] + l.share * c[7] + r.share * c[8];
  const Column above1 = r.density * c[5] - l.density * c[4];
  const Column below1 = r.density * c[8] - l.density * c[7];
  const Column above2 = r.slope * c[5] + l.slope * c[4];
  const Column below2 = r.slope * c[8] + l.slope * c[7];
  const Column& uv_blur = view_.uv;
  const Column uuvv = t.slope * above2 + b.slope * below2;
  const Column uv = b.density * below1 - t.density * above1;
  PatternSample<Column> out;
  out.value = c[0] + l.share * c[1] + r.share * c[2] + t.share * above0 + b.share * below0 +
              uv_blur * (uv + 0.5F * uv_blur * uuvv);
  out.u = r.density * c[2] - l.density * c[1] + t.share * above1 + b.share * below1 +
          uv_blur * (b.density * below2 - t.density * above2);
  out.v = b.density * below0 - t.density * above0 + uv_blur * (t.slope * above1 + b.slope * below1);
  out.uu = r.slope * c[2] + l.slope * c[1] + t.share * above2 + b.share * below2;
  out.vv = t.slope * above0 + b.slope * below0;
  out.uv = uv + uv_blur * uuvv;
  return out;
}

PatternSample<Column> PixelPass::SampleWide() const {
  PatternSample<Column> out;
  for (int i = 0; i < kChunk; ++i) {
    const auto at = [i](const Column& column) { return static_cast<double>(column[i]); };
    const PatternSample<double> sample =
        model_.At(static_cast<double>(h_) * at(view_.u), static_cast<double>(h_) * at(view_.v),
                  {at(view_.uu), at(view_.uv), at(view_.vv)}, normal_);
    out.value[i] = static_cast<float>(sample.value);
    out.u[i] = static_cast<float>(sample.u);
    out.v[i] = static_cast<float>(sample.v);
    out.uu[i] = static_cast<float>(sample.uu);
    out.uv[i] = static_cast<float>(sample.uv);
    out.vv[i] = static_cast<float>(sample.vv);
  }
  return out;
}

// Tukey's weights. A pixel at the sensor's end tells a bound only.
void PixelPass::Weigh(const PatternSample<Column>& sample, int n) {
  constexpr float kFar = 1e6F;
  const Column predicted = light_.illumination * (black_ + gain_ * sample.value);
  residual_ = grey_ - predicted.min(255 + (255 - grey_) * kFar).max(grey_ * -kFar);
  residual_.tail(kChunk - n).setConstant(reach_);
  const Column x2 = (residual_ * (1 / reach_)).square().min(1.0F), rest = 1 - x2;
  weight_ = rest * rest;
  d_psi_ = rest * (1 - 5 * x2);
}

void PixelPass::Count(int n) {
  const float half_contrast = 0.5F * gain_;
  const Column psi = weight_ * residual_;
  float lag1 = 0, lag2 = 0, paired1 = 0, paired2 = 0;
  for (int i = 0; i < n; ++i) {
    const float magnitude = std::abs(residual_[i]);
    magnitudes_.Add(magnitude);
    sums_.contradicted += magnitude > half_contrast ? 1 : 0;
    run_ = follows_[static_cast<size_t>(i)] ? run_ + 1 : 0;
    if (run_ > 0) {
      lag1 += psi[i] * last_psi_[0];
      paired1 += psi[i] * psi[i];
    }
    if (run_ > 1) {
      lag2 += psi[i] * last_psi_[1];
      paired2 += psi[i] * psi[i];
    }
    last_psi_ = {psi[i], last_psi_[0]};
  }
  sums_.lagged[0] += static_cast<double>(lag1);
  sums_.lagged[1] += static_cast<double>(lag2);
  sums_.paired[0] += static_cast<double>(paired1);
  sums_.paired[1] += static_cast<double>(paired2);
  sums_.weight += static_cast<double>(weight_.sum());
  sums_.psi2 += static_cast<double>(psi.square().sum());
  sums_.d_psi += static_cast<double>(d_psi_.sum());
  sums_.used += static_cast<size_t>(n);
}

void PixelPass::Run(const PatternPixels& pixels, size_t stride) {
  constexpr auto kSharp =
      static_cast<float>(1 / (NormalTable::kReach * NormalTable::kReach));  // [cells^2]
  for (size_t first = 0; first < pixels.size(); first += kChunk * stride) {
    const int n = Take(pixels, first, stride);
    Look();
    const bool sharp = view_.uu.maxCoeff() < kSharp && view_.vv.maxCoeff() < kSharp;
    const PatternSample<Column> sample = sharp ? SampleSharp() : SampleWide();
    Weigh(sample, n);
    Count(n);
    PatternDerivatives(view_, sample, light_, h_, black_, gain_,
                       [&](int k) { return rows_.col(k).array(); });
    products_.Add(rows_, weight_, residual_);
  }
}

PatternSums PixelPass::Finish() {
  products_.Finish(&sums_.normal, &sums_.gradient);
  sums_.noise_grey = magnitudes_.Deviation();
  return sums_;
}

}  // namespace

PatternSums SumPattern(const PatternModel& model, const NormalTable& normal,
                       const PatternPixels& pixels, const PatternState& state, double reach_grey,
                       size_t stride) {
  PixelPass pass(model, normal, state, pixels.origin, reach_grey);
  pass.Run(pixels, stride);
  return pass.Finish();
}

}  // namespace tagtwist::internal
