// Follows a run that goes on: the page's server sends its frames, and after the last one they are all here.

export function follow(motion, player) {
  const source = new EventSource("events");
  source.onmessage = ({ data }) => {
    const { frame, poses } = JSON.parse(data);
    motion.write(frame, poses);
    player.seek(motion.time[frame]);
  };
  source.addEventListener("end", () => source.close());
}
