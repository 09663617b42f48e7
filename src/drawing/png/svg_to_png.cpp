#include "cosiva/drawing/png/svg_to_png.h"

#include <cairo.h>
#include <librsvg/rsvg.h>

#include <cmath>
#include <memory>

namespace cosiva::app {
namespace {

constexpr double height_px_max = 16384.0;

struct Release {
  void operator()(RsvgHandle* handle) const { g_object_unref(handle); }
  void operator()(GInputStream* stream) const { g_object_unref(stream); }
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
  void operator()(cairo_t* context) const { cairo_destroy(context); }
  void operator()(GError* error) const { g_error_free(error); }
};
template <typename T>
using Owned = std::unique_ptr<T, Release>;

tl::unexpected<Error> refused(GError* error) {
  const Owned<GError> owned{error};
  return fail("picture.svg",
              std::string("the drawing cannot be rendered: ") + (error == nullptr ? "?" : error->message));
}

cairo_status_t append(void* to, const unsigned char* bytes, unsigned int count) {
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast)
  static_cast<std::string*>(to)->append(reinterpret_cast<const char*>(bytes), count);
  return CAIRO_STATUS_SUCCESS;
}

/// Height over width of a drawing as intended; 0 where the drawing does not state it.
double aspect_of(RsvgHandle* handle) {
  gboolean has_width = FALSE;
  gboolean has_height = FALSE;
  gboolean has_box = FALSE;
  RsvgLength width{};
  RsvgLength height{};
  RsvgRectangle box{};
  rsvg_handle_get_intrinsic_dimensions(handle, &has_width, &width, &has_height, &height, &has_box, &box);
  if (has_box != FALSE && box.width > 0.0) return box.height / box.width;
  return has_width != FALSE && has_height != FALSE && width.length > 0.0 ? height.length / width.length : 0.0;
}

}  // namespace

Result<std::string> png_of(std::string_view svg, std::uint32_t width_px) {
  GError* error = nullptr;
  const Owned<GInputStream> stream{
      g_memory_input_stream_new_from_data(svg.data(), static_cast<gssize>(svg.size()), nullptr)};
  // CoSiVA's own drawing: a large zone's is longer than what the library accepts from unknown sources.
  const Owned<RsvgHandle> handle{
      rsvg_handle_new_from_stream_sync(stream.get(), nullptr, RSVG_HANDLE_FLAG_UNLIMITED, nullptr, &error)};
  if (!handle) return refused(error);
  const double width = width_px;
  const double height = std::ceil(width * aspect_of(handle.get()));
  if (!(height >= 1.0 && height <= height_px_max)) {
    return fail("image.size", "at this width it would be " + std::to_string(std::llround(height)) +
                                  " pixels high; from 1 to 16384 can be drawn");
  }
  const Owned<cairo_surface_t> surface{
      cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(width), static_cast<int>(height))};
  const Owned<cairo_t> context{cairo_create(surface.get())};
  cairo_set_source_rgb(context.get(), 1.0, 1.0, 1.0);
  cairo_paint(context.get());
  const RsvgRectangle viewport{0.0, 0.0, width, height};
  if (rsvg_handle_render_document(handle.get(), context.get(), &viewport, &error) == FALSE) return refused(error);
  std::string png;
  if (cairo_surface_write_to_png_stream(surface.get(), append, &png) != CAIRO_STATUS_SUCCESS)
    return fail("picture.svg", "the image cannot be created; is there enough memory?");
  return png;
}

}  // namespace cosiva::app
