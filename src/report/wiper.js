// Shows the designed picture over another one, up to a line that follows the pointer and the slider.
(() => {
  const wiper = document.querySelector(".wiper");
  const [under, over] = wiper.querySelectorAll("img");
  const slider = wiper.querySelector("input");
  const others = wiper.querySelector("select");
  const pictures = [...document.querySelectorAll(".pair > figure")];
  const designed = pictures.find((figure) => figure.classList.contains("best"));
  const take = (image, figure) => {
    const { src, alt } = figure.querySelector("img");
    Object.assign(image, { src, alt });
  };
  const show = () => wiper.style.setProperty("--at", `${slider.value}%`);
  const follow = (event) => {
    const { left, width } = over.getBoundingClientRect();
    slider.value = (100 * (event.clientX - left)) / width;
    show();
  };
  pictures.forEach((figure, at) => {
    if (figure !== designed) others.add(new Option(figure.querySelector(".name span").textContent, at));
  });
  const compare = () => take(under, pictures[others.value]);
  take(over, designed);
  compare();
  show();
  slider.addEventListener("input", show);
  others.addEventListener("change", compare);
  const stage = wiper.querySelector(".wiped");
  stage.addEventListener("pointerdown", (event) => {
    event.preventDefault();
    stage.setPointerCapture(event.pointerId);
    follow(event);
  });
  stage.addEventListener("pointermove", (event) => event.buttons && follow(event));
  wiper.hidden = false;
})();
