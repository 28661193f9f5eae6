#include "core/report/plot.h"

#include <algorithm>
#include <cmath>

#include "core/report/text.h"
#include "core/report/ticks.h"

namespace lightbatch::report {
namespace {

constexpr std::size_t kColours = 5;
constexpr double kGlyph = 6.6;  // width of a character of a label, pixels: to leave room

std::string open_svg(const std::string& title, int width, double height) {
  const std::string h = coordinate(height);
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"plot\" role=\"img\" viewBox=\"0 0 " +
         std::to_string(width) + " " + h + "\" width=\"" + std::to_string(width) + "\" height=\"" +
         h + "\"><title>" + escape(title) + "</title>\n";
}

std::string label(double x, double y, const std::string& anchor, const std::string& words,
                  const std::string& kind = "tick") {
  return "<text class=\"" + kind + "\" x=\"" + coordinate(x) + "\" y=\"" + coordinate(y) +
         "\" text-anchor=\"" + anchor + "\">" + escape(words) + "</text>\n";
}

std::string line(double x0, double y0, double x1, double y1, const std::string& kind) {
  return "<line class=\"" + kind + "\" x1=\"" + coordinate(x0) + "\" y1=\"" + coordinate(y0) +
         "\" x2=\"" + coordinate(x1) + "\" y2=\"" + coordinate(y1) + "\"/>\n";
}

std::string circle(double x, double y, double radius, const std::string& kind) {
  return "<circle class=\"" + kind + "\" cx=\"" + coordinate(x) + "\" cy=\"" + coordinate(y) +
         "\" r=\"" + coordinate(radius) + "\"/>\n";
}

std::string rectangle(double x, double y, double width, double height, const std::string& kind) {
  return "<rect class=\"" + kind + "\" x=\"" + coordinate(x) + "\" y=\"" + coordinate(y) +
         "\" width=\"" + coordinate(std::max(0.0, width)) + "\" height=\"" + coordinate(height) +
         "\" rx=\"2\"/>\n";
}

std::string colour_class(std::size_t series) {
  std::string name = "c";
  name += std::to_string(series % kColours);
  return name;
}

double text_width(const std::string& words) {
  // Bytes that start a character.
  const auto count = std::count_if(words.begin(), words.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0u) != 0x80u;
  });
  return kGlyph * static_cast<double>(count);
}

class PlotDrawing {
 public:
  explicit PlotDrawing(const Plot& plot)
      : plot_(plot),
        x_(plot.x, values_of(plot, false), std::max(2, plot.width / 80)),
        y_(plot.y, values_of(plot, true), std::max(2, plot.height / 55)) {
    double widest = 0;
    for (const double tick : y_.ticks()) widest = std::max(widest, text_width(y_.name(tick)));
    left_ = widest + 34;
    right_ = plot.width - 22;
    top_ = plot.series.size() > 1 ? 34 : 14;
    bottom_ = plot.height - 46;
  }

  std::string draw() {
    out_ = open_svg(plot_.title, plot_.width, plot_.height);
    draw_axes();
    for (const Mark& mark : plot_.marks) draw_mark(mark);
    bool any = false;
    for (std::size_t i = 0; i < plot_.series.size(); ++i) any = draw_series(i) || any;
    if (!any) out_ += label((left_ + right_) / 2, (top_ + bottom_) / 2, "middle", "no data");
    if (plot_.series.size() > 1) draw_legend();
    return out_ + "</svg>\n";
  }

 private:
  static std::vector<double> values_of(const Plot& plot, bool vertical) {
    std::vector<double> values;
    for (const Series& series : plot.series) {
      for (const PlotPoint& point : series.points) {
        values.push_back(vertical ? point.y : point.x);
        if (vertical && point.low < point.high) {
          values.push_back(point.low);
          values.push_back(point.high);
        }
      }
    }
    for (const Mark& mark : plot.marks) {
      if (mark.vertical != vertical) values.push_back(mark.value);
    }
    return values;
  }

  double px(double x) const { return left_ + x_.place(x) * (right_ - left_); }
  double py(double y) const { return bottom_ - y_.place(y) * (bottom_ - top_); }
  bool shows(const PlotPoint& p) const { return x_.shows(p.x) && y_.shows(p.y); }

  void draw_axes() {
    for (const double tick : x_.ticks()) {
      out_ += line(px(tick), top_, px(tick), bottom_, "grid");
      const double half = text_width(x_.name(tick)) / 2;
      out_ += label(std::min(px(tick), plot_.width - half), bottom_ + 17, "middle", x_.name(tick));
    }
    for (const double tick : y_.ticks()) {
      out_ += line(left_, py(tick), right_, py(tick), "grid");
      out_ += label(left_ - 7, py(tick) + 4, "end", y_.name(tick));
    }
    out_ += line(left_, bottom_, right_, bottom_, "axis");
    out_ += line(left_, top_, left_, bottom_, "axis");
    out_ += label((left_ + right_) / 2, plot_.height - 8, "middle", plot_.x.label, "name");
    out_ += "<text class=\"name\" text-anchor=\"middle\" transform=\"translate(13 " +
            coordinate((top_ + bottom_) / 2) + ") rotate(-90)\">" + escape(plot_.y.label) +
            "</text>\n";
  }

  void draw_mark(const Mark& mark) {
    if (!(mark.vertical ? x_ : y_).shows(mark.value)) return;
    if (mark.vertical) {
      out_ += line(px(mark.value), top_, px(mark.value), bottom_, "mark");
      out_ += label(px(mark.value) + 5, top_ + 12, "start", mark.label, "marked");
    } else {
      out_ += line(left_, py(mark.value), right_, py(mark.value), "mark");
      out_ += label(right_ - 4, py(mark.value) - 5, "end", mark.label, "marked");
    }
  }

  bool draw_series(std::size_t index) {
    const Series& series = plot_.series[index];
    const std::string colour = colour_class(index);
    std::string path, dots;
    for (const PlotPoint& point : series.points) {
      if (!shows(point)) continue;
      const std::string at = coordinate(px(point.x)) + " " + coordinate(py(point.y));
      path += (path.empty() ? "M" : " L") + at;
      if (point.low < point.high && y_.shows(point.high)) {
        // A bar down to 0 leaves a logarithmic plot at its foot.
        const double foot = y_.shows(point.low) ? py(point.low) : bottom_;
        dots += line(px(point.x), foot, px(point.x), py(point.high), "bar " + colour);
      }
      dots +=
          circle(px(point.x), py(point.y), series.points.size() > 60 ? 1.5 : 3.5, "dot " + colour);
    }
    if (path.empty()) return false;
    if (series.line) {
      out_ += "<path class=\"line " + colour + (series.dashed ? " dashed" : "") + "\" d=\"" + path +
              "\"/>\n";
    }
    out_ += dots;
    return true;
  }

  void draw_legend() {
    double x = left_;
    for (std::size_t i = 0; i < plot_.series.size(); ++i) {
      const Series& series = plot_.series[i];
      const std::string colour = colour_class(i);
      if (series.line) {
        out_ += line(x, 14, x + 20, 14, "line " + colour + (series.dashed ? " dashed" : ""));
      } else {
        out_ += circle(x + 12, 14, 3.5, "dot " + colour);
      }
      out_ += label(x + 26, 18, "start", series.name, "name");
      x += 46 + text_width(series.name);
    }
  }

  const Plot& plot_;
  Scale x_, y_;
  double left_ = 0, right_ = 0, top_ = 0, bottom_ = 0;
  std::string out_;
};

}  // namespace

std::string plot_svg(const Plot& plot) { return PlotDrawing(plot).draw(); }

std::string bars_svg(const std::string& title, const std::vector<Bar>& bars, int width) {
  constexpr double kRow = 26;
  double most = 0, left = 40, right = 40;
  for (const Bar& bar : bars) {
    if (std::isfinite(bar.value)) most = std::max(most, bar.value);
    left = std::max(left, text_width(bar.label) + 14);
    right = std::max(right, text_width(bar.text) + 14);
  }
  left = std::min(left, 0.4 * width);
  right = std::min(right, 0.4 * width);
  const double length = width - left - right;
  std::string out = open_svg(title, width, kRow * static_cast<double>(bars.size()) + 6);
  for (std::size_t i = 0; i < bars.size(); ++i) {
    const Bar& bar = bars[i];
    const double y = kRow * static_cast<double>(i) + 4;
    const auto size = [&](double value) {
      return most > 0 && std::isfinite(value) ? length * std::clamp(value / most, 0.0, 1.0) : 0;
    };
    out += label(left - 8, y + 14, "end", bar.label, "name");
    out += rectangle(left, y, length, kRow - 8, "track");
    out += rectangle(left, y, std::max(1.0, size(bar.value)), kRow - 8, "fill c0");
    out += label(left + size(bar.value) + 8, y + 14, "start", bar.text, "tick");
  }
  return out + "</svg>\n";
}

std::string gauge_svg(const Gauge& gauge, int width) {
  const double left = 12, right = width - 12;
  Axis axis{"", Unit::kPercent, false, true};
  const Scale scale(axis, {gauge.value, gauge.high, gauge.target * 1.15}, 6);
  const auto px = [&](double v) {
    return left + (right - left) * std::clamp(scale.place(v), 0.0, 1.0);
  };
  std::string out = open_svg("certified error against its target", width, 84);
  out += rectangle(left, 34, right - left, 12, "track");
  const bool aimed = gauge.target > 0;
  if (aimed) out += rectangle(left, 34, px(gauge.target) - left, 12, "allowed");
  if (gauge.low < gauge.high) {
    out += rectangle(px(gauge.low), 34, px(gauge.high) - px(gauge.low), 12, "interval");
  }
  out += circle(px(gauge.value), 40, 8, "value");
  if (aimed) {
    out += line(px(gauge.target), 26, px(gauge.target), 54, "mark");
    out += label(std::clamp(px(gauge.target), left + 50, right - 50), 19, "middle",
                 "target " + percent_text(gauge.target), "marked");
  }
  for (const double tick : scale.ticks()) {
    out += line(px(tick), 50, px(tick), 55, "axis");
    out += label(std::clamp(px(tick), left + 10, right - 14), 71, "middle", scale.name(tick));
  }
  return out + "</svg>\n";
}

}  // namespace lightbatch::report
