const box=document.getElementById("q"),hits=document.getElementById("hits");let at=0;
const show=()=>{const w=box.value.trim().toLowerCase().split(/\s+/).filter(Boolean);
const rank=e=>{const n=e[0].toLowerCase();return n===w[0]?0:n.startsWith(w[0])?1:n.includes(w[0])?2:3};
const found=w.length?NAMES.filter(e=>w.every(x=>(e[1]+"."+e[0]+" "+e[2]).toLowerCase().includes(x))).sort((a,b)=>rank(a)-rank(b)||a[0].length-b[0].length).slice(0,40):[];
at=0;hits.replaceChildren(...found.map((e,k)=>{const li=document.createElement("li"),a=document.createElement("a"),s=document.createElement("small");
a.href=(e[1]===HERE?"":e[1]+".html")+"#"+e[0];a.textContent=e[0];s.textContent=e[1]+(e[2]?" · "+e[2]:"");a.append(s);li.append(a);li.className=k?"":"on";return li}))};
box.addEventListener("input",show);
box.addEventListener("keydown",e=>{const n=hits.children.length;if(!n)return;
if(e.key==="ArrowDown"||e.key==="ArrowUp"){e.preventDefault();hits.children[at].className="";at=(at+(e.key==="ArrowDown"?1:n-1))%n;hits.children[at].className="on";hits.children[at].scrollIntoView({block:"nearest"})}
else if(e.key==="Enter"){location.href=hits.children[at].firstChild.href;hits.replaceChildren();box.blur()}
else if(e.key==="Escape"){box.value="";show()}});
document.addEventListener("keydown",e=>{if(e.key==="/"&&document.activeElement!==box){e.preventDefault();box.focus()}});
hits.addEventListener("click",()=>{hits.replaceChildren();box.value=""});
show();
