#pragma once

#include <string>
#include <vector>

namespace lightbatch::report {

enum class Unit { kNumber, kPercent, kSeconds, kBytes };

struct Axis {
  std::string label;
  Unit unit = Unit::kNumber;
  bool logarithmic = false;
  bool from_zero = false;  // a linear axis starts at 0 whatever the data
};

struct PlotPoint {
  double x = 0;
  double y = 0;
  double low = 0;  // error bar when low < high
  double high = 0;
};

struct Series {
  std::string name;
  std::vector<PlotPoint> points;
  bool line = true;
  bool dashed = false;
};

/// A line across the plot, with a word to it: a target, the chosen setting.
struct Mark {
  std::string label;
  double value = 0;
  bool vertical = false;
};

struct Plot {
  std::string title;  // for those who cannot see it
  Axis x, y;
  std::vector<Series> series;
  std::vector<Mark> marks;
  int width = 640;
  int height = 340;
};

/// The plot as <svg>: axes with round ticks, grid, legend for more than one series. Points that are
/// not finite (or not positive on a logarithmic axis) are left out; a plot without points says so.
/// Colours come from the classes of plot_style().
std::string plot_svg(const Plot& plot);

struct Bar {
  std::string label;
  double value = 0;
  std::string text;  // beside the bar
};
/// Horizontal bars, one below the other.
std::string bars_svg(const std::string& title, const std::vector<Bar>& bars, int width = 640);

/// Range on a line from 0: an interval, its middle, and a target.
struct Gauge {
  double value = 0, low = 0, high = 0, target = 0;  // target 0: none
};
std::string gauge_svg(const Gauge& gauge, int width = 640);

/// Style rules of the classes used in drawings, for light and dark: part of the page, or of a
/// drawing that stands alone.
std::string plot_style();
/// The same drawing as a file of its own.
std::string standalone_svg(const std::string& svg);

}  // namespace lightbatch::report
