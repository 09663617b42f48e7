#pragma once

#include <array>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// SVG 1.1 text, made element by element.
namespace cosiva::drawing {

/// A number for display: at most this number of decimals, without trailing zeros; "–" where it is not finite.
[[nodiscard]] std::string readable(double number, int digits = 3);
/// Escapes a text for HTML and XML. Control characters that XML 1.0 cannot express are left out.
[[nodiscard]] std::string escaped(std::string_view text);

/// Red, green and blue, each in [0, 255].
using Rgb = std::array<double, 3>;
/// The colour at `ratio` of the scale from the first to the last of evenly spaced stops, as "#rrggbb".
/// @param ratio  is limited to [0, 1]
/// @param stops  two or more (checked)
[[nodiscard]] std::string colour_between(std::span<const Rgb> stops, double ratio);

enum class TextAlign { centre, end };

/// Writes elements in the order of the calls. A container (`open`, `close`) holds other elements, a shape (`shape`)
/// only a title or a text; it ends where the next element begins. Names of elements and attributes are written as they
/// are, values and texts are escaped.
/// Invariant: attributes are added only to an element that has no content yet; every container is closed.
class SvgWriter {
 public:
  /// @param digits  decimals of every coordinate and length, 0 to 9 (checked)
  explicit SvgWriter(int digits);

  SvgWriter& open(std::string_view container);
  SvgWriter& close();
  SvgWriter& shape(std::string_view name);

  SvgWriter& attribute(std::string_view name, std::string_view value);
  SvgWriter& attribute(std::string_view name, double value);
  /// A list of numbers with blanks between them, such as a viewBox.
  SvgWriter& attribute(std::string_view name, std::initializer_list<double> values);
  SvgWriter& at(double x, double y);
  SvgWriter& size(double width, double height);

  /// Which part of a text, or of each text in a container, is at its position; without: its start.
  SvgWriter& align(TextAlign align);

  /// The name that a browser shows when the pointer is on the element.
  SvgWriter& title(std::string_view text);
  SvgWriter& text(std::string_view text);

  /// A number as in this drawing's attributes, for the data of a path.
  [[nodiscard]] std::string number(double value) const { return readable(value, digits_); }
  /// The drawing; the writer is empty afterwards. All containers are closed (checked).
  [[nodiscard]] std::string take();

 private:
  enum class Part {
    content,         ///< outside a start tag
    container_head,  ///< in the start tag of a container
    shape_head,      ///< in the start tag of a shape
    shape_content    ///< after the start tag of a shape
  };
  /// Ends the shape or the start tag that is being written.
  void finish();
  void begin_content();

  int digits_;
  Part part_{Part::content};
  std::string shape_;
  std::vector<std::string> containers_;
  std::string out_;
};

}  // namespace cosiva::drawing
