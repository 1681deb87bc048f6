// Sheets through cairo: PDF, SVG and pixels from one drawing.
#include "vision/boards/sheets.h"

#include <cairo-pdf.h>
#include <cairo-svg.h>

#include <cmath>
#include <memory>
#include <new>

namespace skein::vision {
namespace {

constexpr double points_per_mm = 72.0 / 25.4;

struct SurfaceDeleter {
  void operator()(cairo_surface_t* s) const { cairo_surface_destroy(s); }
};
struct ContextDeleter {
  void operator()(cairo_t* c) const { cairo_destroy(c); }
};
using Surface = std::unique_ptr<cairo_surface_t, SurfaceDeleter>;
using Context = std::unique_ptr<cairo_t, ContextDeleter>;

/// Millimetres as the surface's unit.
void paint(cairo_t* context, const Page& page) {
  cairo_set_source_rgb(context, 1.0, 1.0, 1.0);
  cairo_paint(context);
  cairo_set_source_rgb(context, 0.0, 0.0, 0.0);
  // One path: the seams between its parts stay black.
  for (const Page::Rectangle& r : page.rectangles) cairo_rectangle(context, r.x, r.y, r.width, r.height);
  cairo_fill(context);
  for (const Page::Triangle& t : page.triangles) {
    cairo_move_to(context, t.x[0], t.y[0]);
    cairo_line_to(context, t.x[1], t.y[1]);
    cairo_line_to(context, t.x[2], t.y[2]);
    cairo_close_path(context);
  }
  cairo_fill(context);
  for (const Page::Line& line : page.lines) {
    const double dashes[2] = {1.0, 1.5};
    cairo_set_dash(context, dashes, line.dashed ? 2 : 0, 0.0);
    cairo_set_line_width(context, line.width);
    cairo_move_to(context, line.x1, line.y1);
    cairo_line_to(context, line.x2, line.y2);
    cairo_stroke(context);
  }
  cairo_select_font_face(context, "sans", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  for (const Page::Words& words : page.words) {
    cairo_set_font_size(context, words.size);
    cairo_move_to(context, words.x, words.y);
    cairo_show_text(context, words.text.c_str());
  }
}

std::string problem_of(cairo_status_t status) {
  return status == CAIRO_STATUS_SUCCESS ? std::string() : cairo_status_to_string(status);
}

}  // namespace

std::string draw_sheet(const std::vector<Page>& pages, bool pdf, std::string& file) {
  if (pages.empty()) return "there is nothing on it";
  const double width = pages[0].width * points_per_mm;
  const double height = pages[0].height * points_per_mm;
  file.clear();
  const cairo_write_func_t write = [](void* to, const unsigned char* bytes, unsigned size) {
    try {
      static_cast<std::string*>(to)->append(reinterpret_cast<const char*>(bytes), size);
      return CAIRO_STATUS_SUCCESS;
    } catch (const std::bad_alloc&) {  // cairo is C
      return CAIRO_STATUS_NO_MEMORY;
    }
  };
  const Surface surface(pdf ? cairo_pdf_surface_create_for_stream(write, &file, width, height)
                            : cairo_svg_surface_create_for_stream(write, &file, width, height));
  if (!pdf) cairo_svg_surface_set_document_unit(surface.get(), CAIRO_SVG_UNIT_PT);
  {
    const Context context(cairo_create(surface.get()));
    for (const Page& page : pages) {
      if (pdf) cairo_pdf_surface_set_size(surface.get(), page.width * points_per_mm, page.height * points_per_mm);
      cairo_save(context.get());
      cairo_scale(context.get(), points_per_mm, points_per_mm);
      paint(context.get(), page);
      cairo_restore(context.get());
      cairo_show_page(context.get());
    }
    if (const auto status = cairo_status(context.get()); status != CAIRO_STATUS_SUCCESS) return problem_of(status);
  }
  cairo_surface_finish(surface.get());
  return problem_of(cairo_surface_status(surface.get()));
}

std::string rasterise_sheet(const Page& page, double px_per_mm, Frame& frame) {
  const int width = static_cast<int>(std::lround(page.width * px_per_mm));
  const int height = static_cast<int>(std::lround(page.height * px_per_mm));
  const Surface surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height));
  if (const auto status = cairo_surface_status(surface.get()); status != CAIRO_STATUS_SUCCESS)
    return problem_of(status);
  {
    const Context context(cairo_create(surface.get()));
    cairo_scale(context.get(), px_per_mm, px_per_mm);
    paint(context.get(), page);
  }
  cairo_surface_flush(surface.get());
  frame.resize(width, height);
  const unsigned char* pixels = cairo_image_surface_get_data(surface.get());
  const int stride = cairo_image_surface_get_stride(surface.get());
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      frame.row(v)[u] = pixels[static_cast<std::ptrdiff_t>(v) * stride + 4 * static_cast<std::ptrdiff_t>(u)];
  return {};
}

}  // namespace skein::vision
